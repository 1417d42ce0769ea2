//! How the viewer's window is divided, and where its eye stands.
//!
//! Written as records of the viewer's own blueprint store: its builders have no word for the eye.

use super::camera::camera;
use super::curves::Plot;
use super::entity::{CAPTION, STATICS, TIMELINE};
use super::marks::EVENTS;
use super::picture::Picture;
use super::sdk::blueprint::archetypes::{
    Background, ContainerBlueprint, EyeControls3D, LineGrid3D, PanelBlueprint, PlotLegend, TextLogColumns,
    TimePanelBlueprint, ViewBlueprint, ViewContents, ViewportBlueprint,
};
use super::sdk::blueprint::components::{
    BackgroundKind, ContainerKind, Corner2D, LoopMode, PanelState, PlayState, RootContainer,
};
use super::sdk::blueprint::datatypes::{TextLogColumn, TextLogColumnKind};
use super::sdk::datatypes::Uuid;
use super::sdk::{Color, EntityPath, components};
use super::sent::Sent;
use super::stream::Stream;
use crate::record::drawing::bounds::Bounds;
use crate::record::drawing::has_ground;

/// Shares of the window's width: the bodies, the plots.
const SHARES: [f32; 2] = [3.0, 2.0];
/// Shares of its height: the log, all other rows.
const LOG_SHARE: f32 = 0.6;
const ROW_SHARE: f32 = 1.0;
/// Light, as paper: wires, rods and frames are usually dark.
const BACKGROUND: Color = Color(super::sdk::Rgba32::from_rgb(224, 228, 233));
const GRID: Color = Color(super::sdk::Rgba32::from_rgb(190, 196, 204));

/// Sends the layout: the bodies on the left with the eye on the whole of `bounds`, on the right what statics found, what
/// happens and the plots, those of one group behind each other. With `plays` the time runs as soon as it is opened.
pub(super) fn send(stream: &Stream, picture: &Picture, bounds: &Bounds, plays: bool) -> Sent {
    let title = picture.scene.title.as_str();
    let blueprint = stream.layout()?;
    let mut ids = Ids(0);
    let bodies = ids.path("view");
    send_bodies(
        &blueprint,
        &bodies,
        if title.is_empty() { "Bodies" } else { title },
        (bounds, has_ground(&picture.scene)),
    )?;
    let mut rows = Vec::new();
    for (shown, origin, name) in
        [(!picture.captions.is_empty(), CAPTION, "Now"), (picture.statics.is_some(), STATICS, "Statics")]
    {
        // What is shown now says all of the mode; the list of all would only be longer.
        if shown && rows.is_empty() {
            let text = ids.path("view");
            send_text(&blueprint, &text, name, origin)?;
            rows.push(text);
        }
    }
    let mut shares = vec![ROW_SHARE; rows.len()];
    if picture.scene.watched {
        let log = ids.path("view");
        send_view(&blueprint, &log, "TextLog", "Events", vec![format!("+ {}/**", super::entity::path(&[EVENTS]))])?;
        // A line names what it happened to.
        let line = TextLogColumn { visible: true.into(), kind: TextLogColumnKind::Body };
        blueprint.log(format!("{log}/TextLogColumns"), &TextLogColumns::new().with_text_log_columns([line]))?;
        rows.push(log);
        shares.push(LOG_SHARE);
    }
    for group in picture.plots.iter().filter(|group| !group.is_empty()) {
        rows.push(send_tabs(&blueprint, &mut ids, group)?);
        shares.push(ROW_SHARE);
    }
    let plots = ids.path("container");
    let looks = ContainerBlueprint::new(ContainerKind::Vertical).with_contents(rows).with_row_shares(shares);
    blueprint.log(plots.as_str(), &looks)?;
    let window = ids.next();
    let halves = ContainerBlueprint::new(ContainerKind::Horizontal).with_contents([bodies, plots]);
    blueprint.log(format!("container/{window}"), &halves.with_col_shares(SHARES))?;
    send_frame(&blueprint, window, plays)?;
    blueprint.activate()
}

/// Names for the parts of the window.
struct Ids(u128);

impl Ids {
    fn next(&mut self) -> Uuid {
        self.0 += 1;
        Uuid { bytes: self.0.to_be_bytes() }
    }

    fn path(&mut self, kind: &str) -> String {
        format!("{kind}/{}", self.next())
    }
}

/// The window itself and what lies around it.
fn send_frame(blueprint: &Stream, window: Uuid, plays: bool) -> Sent {
    let viewport = ViewportBlueprint::new()
        .with_root_container(RootContainer(window))
        .with_auto_layout(false)
        .with_auto_views(false);
    blueprint.log("viewport", &viewport)?;
    for panel in ["blueprint_panel", "selection_panel"] {
        blueprint.log(panel, &PanelBlueprint::new().with_state(PanelState::Collapsed))?;
    }
    let time = TimePanelBlueprint::new().with_state(PanelState::Collapsed).with_timeline(TIMELINE);
    let state = if plays { PlayState::Playing } else { PlayState::Following };
    blueprint.log("time_panel", &time.with_loop_mode(LoopMode::All).with_play_state(state))
}

fn send_tabs(blueprint: &Stream, ids: &mut Ids, plots: &[Plot]) -> Sent<String> {
    let mut tabs = Vec::new();
    for plot in plots {
        let view = ids.path("view");
        let contents = plot.curves.iter().map(|curve| format!("+ {}", curve.path));
        send_view(blueprint, &view, "TimeSeries", &plot.title, contents.collect())?;
        blueprint.log(format!("{view}/PlotLegend"), &PlotLegend::new().with_corner(Corner2D::RightTop))?;
        tabs.push(view);
    }
    let container = ids.path("container");
    let first = tabs[0].clone();
    let looks = ContainerBlueprint::new(ContainerKind::Tabs).with_contents(tabs).with_active_tab(first.as_str());
    blueprint.log(container.as_str(), &looks)?;
    Ok(container)
}

fn send_text(blueprint: &Stream, view: &str, title: &str, origin: &str) -> Sent {
    let looks = ViewBlueprint::new("TextDocument").with_display_name(title).with_space_origin(origin);
    blueprint.log(view, &looks)?;
    blueprint.log(format!("{view}/ViewContents"), &ViewContents::new(["+ $origin".to_owned()]))
}

/// The bodies within their bounds, and a grid on the ground if there is one.
fn send_bodies(blueprint: &Stream, view: &str, title: &str, (bounds, has_ground): (&Bounds, bool)) -> Sent {
    let parts = ["world", "beams", "springs", "loads", "reactions", "contacts", "center of mass"];
    let contents = parts.map(|part| format!("+ {}/**", super::entity::path(&[part])));
    send_view(blueprint, view, "3D", title, contents.into())?;
    let camera = camera(bounds);
    let eye = EyeControls3D::new()
        .with_position(position(&camera.eye))
        .with_look_target(position(&camera.target))
        .with_eye_up([0.0, 0.0, 1.0]);
    blueprint.log(format!("{view}/EyeControls3D"), &eye)?;
    let ground = Background::new(BackgroundKind::SolidColor).with_color(BACKGROUND);
    blueprint.log(format!("{view}/Background"), &ground)?;
    let grid = LineGrid3D::new()
        .with_visible(has_ground)
        .with_plane(components::Plane3D::new([0.0, 0.0, 1.0], camera.floor as f32))
        .with_spacing(camera.spacing as f32)
        .with_stroke_width(0.7)
        .with_color(GRID);
    blueprint.log(format!("{view}/LineGrid3D"), &grid)
}

fn send_view(blueprint: &Stream, view: &str, class: &str, title: &str, contents: Vec<String>) -> Sent {
    let looks = ViewBlueprint::new(class).with_display_name(title).with_space_origin("/");
    blueprint.log(view, &looks)?;
    blueprint.log(EntityPath::from(format!("{view}/ViewContents")), &ViewContents::new(contents))
}

fn position(at: &nalgebra::Vector3<f64>) -> components::Position3D {
    components::Position3D::from(<[f32; 3]>::from(at.cast::<f32>()))
}
