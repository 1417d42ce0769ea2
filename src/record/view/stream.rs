//! Rows and columns on their way to a viewer or into a file, as the messages of its log.

use super::entity::TIMELINE;
use super::remote::Remote;
use super::sdk::{
    AsComponents, BlueprintActivationCommand, Chunk, CrateVersion, Encoder, EntityPath, LogMsg, RecordingInfo, RowId,
    SerializedComponentColumn, SetStoreInfo, StoreId, StoreInfo, StoreKind, StoreSource, TimeCell, TimeColumn,
    TimePoint, Timestamp, rrd,
};
use super::sent::{Failure, Sent};
use std::fs::File;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// The name under which the viewer keeps layouts and recordings.
const APPLICATION: &str = "stillpoint";
/// The timeline of a layout, with one instant.
const LAYOUT_TIMELINE: &str = "blueprint";

/// A store of the viewer's: a recording, or the layout of its window.
pub(super) struct Stream {
    store: StoreId,
    /// When rows are: never in a recording, which makes them static.
    now: TimePoint,
    outlet: Arc<Mutex<Outlet>>,
}

/// Where messages go.
enum Outlet {
    File(Box<Encoder<File>>),
    Viewer(Remote),
}

impl Stream {
    /// A recording of that title in a new file.
    pub(super) fn save(path: &Path, title: &str) -> Sent<Self> {
        let options = rrd::EncodingOptions::PROTOBUF_COMPRESSED;
        let encoder = Encoder::new_eager(CrateVersion::LOCAL, options, File::create(path)?)?;
        Self::recording(Outlet::File(Box::new(encoder)), title)
    }

    /// A recording of that title for a viewer that listens at `host:port`.
    pub(super) fn connect(place: &str, title: &str) -> Sent<Self> {
        Self::recording(Outlet::Viewer(Remote::connect(place)?), title)
    }

    fn recording(outlet: Outlet, title: &str) -> Sent<Self> {
        let outlet = Arc::new(Mutex::new(outlet));
        let stream = Self::open(StoreKind::Recording, TimePoint::STATIC, outlet)?;
        let mut about = RecordingInfo::new().with_start_time(Timestamp::now().nanos_since_epoch());
        if !title.is_empty() {
            about = about.with_name(title);
        }
        stream.log(EntityPath::properties(), &about)?;
        Ok(stream)
    }

    /// A layout of the window in which this recording is shown. It is taken up with [`Stream::activate`].
    pub(super) fn layout(&self) -> Sent<Self> {
        let now = TimePoint::from([(LAYOUT_TIMELINE, TimeCell::from_sequence(0))]);
        Self::open(StoreKind::Blueprint, now, self.outlet.clone())
    }

    fn open(kind: StoreKind, now: TimePoint, outlet: Arc<Mutex<Outlet>>) -> Sent<Self> {
        let store = StoreId::random(kind, APPLICATION);
        let stream = Self { store: store.clone(), now, outlet };
        let info = StoreInfo::new(store, StoreSource::Other(APPLICATION.into()));
        stream.send(&LogMsg::SetStoreInfo(SetStoreInfo { row_id: *RowId::new(), info }))?;
        Ok(stream)
    }

    /// Sends one row: for all times in a recording, at the only instant of a layout.
    pub(super) fn log(&self, path: impl Into<EntityPath>, row: &dyn AsComponents) -> Sent {
        self.log_row(path.into(), self.now.clone(), row)
    }

    /// Sends one row at a time (s).
    pub(super) fn log_at(&self, path: impl Into<EntityPath>, time: f64, row: &dyn AsComponents) -> Sent {
        let time = TimeCell::from_duration_nanos((1e9 * time).round() as i64);
        self.log_row(path.into(), TimePoint::from([(TIMELINE, time)]), row)
    }

    fn log_row(&self, path: EntityPath, time: TimePoint, row: &dyn AsComponents) -> Sent {
        self.send_chunk(&Chunk::builder(path).with_archetype(RowId::new(), time, row).build()?)
    }

    /// Sends a row for each of the times.
    pub(super) fn send_columns(
        &self,
        path: impl Into<EntityPath>,
        times: TimeColumn,
        columns: impl IntoIterator<Item = SerializedComponentColumn>,
    ) -> Sent {
        let columns = columns.into_iter().map(|column| (column.descriptor, column.list_array));
        self.send_chunk(&Chunk::from_columns(path, [times], columns)?)
    }

    /// Shows the window in this layout, from now on and whenever the viewer falls back to its default.
    pub(super) fn activate(self) -> Sent {
        let command =
            BlueprintActivationCommand { blueprint_id: self.store.clone(), make_active: true, make_default: true };
        self.send(&LogMsg::BlueprintActivationCommand(command))
    }

    fn send_chunk(&self, chunk: &Chunk) -> Sent {
        self.send(&LogMsg::ArrowMsg(self.store.clone(), chunk.to_arrow_msg()?))
    }

    fn send(&self, message: &LogMsg) -> Sent {
        match &mut *self.outlet.lock().unwrap_or_else(PoisonError::into_inner) {
            Outlet::File(encoder) => encoder.append(message).map(drop).map_err(Failure::from),
            Outlet::Viewer(remote) => remote.send(message),
        }
    }

    /// Ends the file, or waits until the viewer has confirmed that it took in everything.
    pub(super) fn finish(self) -> Sent {
        match &mut *self.outlet.lock().unwrap_or_else(PoisonError::into_inner) {
            Outlet::File(encoder) => encoder.finish().map_err(Failure::from),
            Outlet::Viewer(remote) => remote.finish(),
        }
    }
}
