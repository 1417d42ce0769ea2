//! What is used of the Rerun SDK. The crate `rerun` collects the same names, and brings chunk stores, queries and video,
//! which a sender has no use for.

pub(super) use re_sdk::external::re_log_types::BlueprintActivationCommand;
pub(super) use re_sdk::external::re_uri::RedapUri;
pub(super) use re_sdk::log::TimeColumn;
pub(super) use re_sdk::{
    DEFAULT_SERVER_PORT, EntityPath, EntityPathPart, RecordingStream, RecordingStreamBuilder, RecordingStreamResult,
    SerializedComponentColumn, build_info,
};
pub(super) use re_sdk_types::archetypes::{
    Arrows3D, Asset3D, Boxes3D, Capsules3D, Cylinders3D, Ellipsoids3D, InstancePoses3D, LineStrips3D, Points3D,
    Scalars, SeriesLines, TextDocument, TextLog, Transform3D, ViewCoordinates,
};
pub(super) use re_sdk_types::components::{AlbedoFactor, Color, FillMode, MediaType, Radius, TextLogLevel};
pub(super) use re_sdk_types::datatypes::{Quaternion, Rgba32};
pub(super) use re_sdk_types::{blueprint, components, datatypes};
