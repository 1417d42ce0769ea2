//! How the viewer's window is divided, and where its eye stands.
//!
//! Written as records of the viewer's own blueprint store: its builders have no word for the eye.

use super::bounds::Bounds;
use super::camera::camera;
use super::columns::TIMELINE;
use super::curves::Plot;
use rerun::blueprint::components::{ContainerKind, LoopMode, PanelState};
use rerun::datatypes::Uuid;
use rerun::external::re_log_types::BlueprintActivationCommand;
use rerun::external::re_sdk_types::blueprint::archetypes::{
    ContainerBlueprint, EyeControls3D, LineGrid3D, PanelBlueprint, TimePanelBlueprint, ViewBlueprint, ViewContents,
    ViewportBlueprint,
};
use rerun::{Color, EntityPath, RecordingStream, RecordingStreamBuilder, RecordingStreamResult, components};

/// Shares of the window's width: the bodies, the plots.
const SHARES: [f32; 2] = [3.0, 2.0];

/// Sends the layout: the bodies on the left with the eye on the whole of `bounds`, the plots on the right.
pub(super) fn send(
    stream: &RecordingStream,
    application: &'static str,
    plots: &[Plot],
    bounds: &Bounds,
) -> RecordingStreamResult<()> {
    let (blueprint, storage) = RecordingStreamBuilder::new(application).blueprint().memory()?;
    blueprint.set_time_sequence("blueprint", 0);
    let mut count = 0u128;
    let mut id = || {
        count += 1;
        Uuid { bytes: count.to_be_bytes() }
    };

    let bodies = format!("view/{}", id());
    send_bodies(&blueprint, &bodies, bounds)?;
    let mut right = Vec::new();
    for plot in plots {
        let view = format!("view/{}", id());
        let contents = plot.curves.iter().map(|curve| format!("+ {}", curve.path));
        send_view(&blueprint, &view, "TimeSeries", &plot.title, contents.collect())?;
        right.push(view);
    }
    let column = format!("container/{}", id());
    blueprint.log(column.as_str(), &ContainerBlueprint::new(ContainerKind::Vertical).with_contents(right))?;
    let root = id();
    let window =
        ContainerBlueprint::new(ContainerKind::Horizontal).with_contents([bodies, column]).with_col_shares(SHARES);
    blueprint.log(format!("container/{root}"), &window)?;
    let viewport = ViewportBlueprint::new()
        .with_root_container(rerun::blueprint::components::RootContainer(root))
        .with_auto_layout(false)
        .with_auto_views(false);
    blueprint.log("viewport", &viewport)?;
    for panel in ["blueprint_panel", "selection_panel"] {
        blueprint.log(panel, &PanelBlueprint::new().with_state(PanelState::Collapsed))?;
    }
    let time = TimePanelBlueprint::new()
        .with_state(PanelState::Collapsed)
        .with_timeline(TIMELINE)
        .with_loop_mode(LoopMode::All);
    blueprint.log("time_panel", &time)?;

    let Some(store) = blueprint.store_info() else { return Ok(()) };
    let activation = BlueprintActivationCommand { blueprint_id: store.store_id, make_active: true, make_default: true };
    stream.send_blueprint(storage.take(), activation);
    Ok(())
}

fn send_bodies(blueprint: &RecordingStream, view: &str, bounds: &Bounds) -> RecordingStreamResult<()> {
    send_view(blueprint, view, "3D", "Bodies", vec!["+ /world/**".into(), "+ /springs/**".into()])?;
    let camera = camera(bounds);
    let eye = EyeControls3D::new()
        .with_position(position(&camera.eye))
        .with_look_target(position(&camera.target))
        .with_eye_up([0.0, 0.0, 1.0]);
    blueprint.log(format!("{view}/EyeControls3D"), &eye)?;
    let grid = LineGrid3D::new()
        .with_plane(components::Plane3D::new([0.0, 0.0, 1.0], camera.floor as f32))
        .with_spacing(camera.spacing as f32)
        .with_color(Color::from_unmultiplied_rgba(150, 150, 150, 60));
    blueprint.log(format!("{view}/LineGrid3D"), &grid)
}

fn send_view(
    blueprint: &RecordingStream,
    view: &str,
    class: &str,
    title: &str,
    contents: Vec<String>,
) -> RecordingStreamResult<()> {
    let looks = ViewBlueprint::new(class).with_display_name(title).with_space_origin("/");
    blueprint.log(view, &looks)?;
    blueprint.log(EntityPath::from(format!("{view}/ViewContents")), &ViewContents::new(contents))
}

fn position(at: &nalgebra::Vector3<f64>) -> components::Position3D {
    components::Position3D::from(<[f32; 3]>::from(at.cast::<f32>()))
}
