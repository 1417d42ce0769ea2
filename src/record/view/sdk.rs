//! What is used of Rerun's crates. Its SDK is made of the same ones, and brings readers of MCAP, video and images, which a
//! sender has no use for.

pub(super) use re_build_info::CrateVersion;
pub(super) use re_chunk::{Chunk, RowId, TimeColumn};
pub(super) use re_log_encoding::{Encoder, ToTransport, rrd};
pub(super) use re_log_types::{
    BlueprintActivationCommand, EntityPath, EntityPathPart, LogMsg, SetStoreInfo, StoreId, StoreInfo, StoreKind,
    StoreSource, TimeCell, TimePoint, Timestamp,
};
pub(super) use re_protos::sdk_comms::v1alpha1::WriteMessagesRequest;
pub(super) use re_protos::sdk_comms::v1alpha1::message_proxy_service_client::MessageProxyServiceClient;
pub(super) use re_sdk_types::archetypes::{
    Arrows3D, Asset3D, Boxes3D, Capsules3D, Cylinders3D, Ellipsoids3D, InstancePoses3D, LineStrips3D, Mesh3D, Points3D,
    RecordingInfo, Scalars, SeriesLines, TextDocument, TextLog, Transform3D, ViewCoordinates,
};
pub(super) use re_sdk_types::components::{AlbedoFactor, Color, FillMode, MediaType, Radius, TextLogLevel};
pub(super) use re_sdk_types::datatypes::{Quaternion, Rgba32};
pub(super) use re_sdk_types::{AsComponents, SerializedComponentColumn, blueprint, components, datatypes};
