//! The examples of `--help`; a test runs every line of them.

pub(super) const PROGRAM: &str = "\
Examples:
  stillpoint new arm.toml --kind robot
  stillpoint statics arm.toml
  stillpoint run arm.toml --set simulate.duration=2
  stillpoint info arm.mcap";

pub(super) const RUN: &str = "\
Examples:
  stillpoint run scenarios/hanging_chain.toml --out chain.mcap --set simulate.duration=2
  stillpoint run scenarios/pendulum.toml --set rod.position=0.5 --verify
  stillpoint new - --kind chain | stillpoint run - --json";

pub(super) const STATICS: &str = "\
Examples:
  stillpoint statics scenarios/calder_mobile.toml --json
  stillpoint statics scenarios/pencil.toml --set 'statics.want=\"any\"'
  stillpoint statics scenarios/double_wishbone.toml --sensitivity camber 'frequency[0]'
  stillpoint statics scenarios/machine_on_mounts.toml --save start.toml";

pub(super) const REST: &str = "\
Examples:
  stillpoint rest scenarios/machine_on_mounts.toml
  stillpoint rest scenarios/double_pendulum.toml --set simulate.duration=2 --json";

pub(super) const PRECISION: &str = "\
Examples:
  stillpoint precision scenarios/pendulum.toml --set simulate.duration=1 --error 1e-6";

pub(super) const SWEEP: &str = "\
Examples:
  stillpoint sweep scenarios/machine_on_mounts.toml --over machine.mass=200:400:5
  stillpoint sweep scenarios/pendulum.toml --over rod.mass=1,2 --over rod.position=0.1:0.9:3 --json
  stillpoint sweep scenarios/machine_on_mounts.toml --vary 'machine.mass=normal(160,4)' --cases 1000 --out mounts";

pub(super) const STUDY: &str = "\
Examples:
  stillpoint study mounts
  stillpoint study mounts --of machine.z --svg machine_z.svg
  stillpoint study scenarios/fits/test_rig.toml --fit scenarios/fits/test_rig_static.csv --parameter arm.stiffness arm.rest";

pub(super) const INSPECT: &str = "\
Examples:
  stillpoint inspect scenarios/pendulum.toml --set rod.position=0.5
  stillpoint inspect scenarios/four_bar.toml --json";

pub(super) const BENCH: &str = "\
Examples:
  stillpoint bench scenarios/pendulum.toml --json";

pub(super) const VIEW: &str = "\
Examples:
  stillpoint view pendulum.mcap --save pendulum.glb
  stillpoint view pendulum.mcap --save pendulum.rrd
  stillpoint view pendulum.mcap";

pub(super) const PICTURE: &str = "\
Examples:
  stillpoint picture pendulum.mcap --at 1.5 -o pendulum.svg
  stillpoint picture pendulum.mcap --camera front --size 800x600 --reactions -o forces.svg";

#[cfg(feature = "picture")]
pub(super) const VIDEO: &str = "\
Examples:
  stillpoint video pendulum.mcap -o pendulum.gif --size 320x240 --rate 10";

pub(super) const REPORT: &str = "\
Examples:
  stillpoint report scenarios/double_wishbone.toml --statics -o wishbone.html
  stillpoint report scenarios/pendulum.toml --verify -o pendulum.html
  stillpoint report pendulum.mcap -o pendulum.html";

pub(super) const WATCH: &str = "\
Examples:
  stillpoint watch scenarios/double_wishbone.toml --times 1
  stillpoint watch scenarios/pendulum.toml --run --report pendulum.html --times 1";

pub(super) const INFO: &str = "\
Examples:
  stillpoint info pendulum.mcap
  stillpoint info pendulum.mcap --json";

pub(super) const RECOVER: &str = "\
Examples:
  stillpoint recover killed.mcap.partial
  stillpoint recover killed.mcap.partial --out saved.mcap";

pub(super) const EXPORT: &str = "\
Examples:
  stillpoint export pendulum.mcap --csv tables
  stillpoint export pendulum.mcap --csv angle.csv --channel rod.angle --channel rod.rate
  stillpoint export pendulum.mcap -o pendulum.parquet";

pub(super) const FMU: &str = "\
Examples:
  stillpoint fmu scenarios/machine_on_mounts.toml --parameter machine.mass --describe
  stillpoint fmu scenarios/machine_on_mounts.toml --library libstillpoint_fmu.so -o machine.fmu";

pub(super) const PLOT: &str = "\
Examples:
  stillpoint plot pendulum.mcap rod.angle rod.rate
  stillpoint plot pendulum.mcap rod.rate --x rod.angle -o phase.svg
  stillpoint plot pendulum.mcap double_pendulum.mcap energy -o energies.svg";

pub(super) const COMPARE: &str = "\
Examples:
  stillpoint compare pendulum.mcap copy.mcap
  stillpoint compare pendulum.mcap copy.mcap --channel rod.angle --tolerance 1e-9";

pub(super) const LINEARIZE: &str = "\
Examples:
  stillpoint linearize scenarios/pendulum.toml --input rod.force --out pendulum.npz
  stillpoint linearize scenarios/double_wishbone.toml --input bump --output camber --bode camber.svg";

pub(super) const CONVERT: &str = "\
Examples:
  stillpoint convert robot.urdf -o robot.toml
  stillpoint convert robot.urdf --floating";

pub(super) const CHECK: &str = "\
Examples:
  stillpoint check scenarios/*.toml
  stillpoint new - | stillpoint check -";

pub(super) const NEW: &str = "\
Examples:
  stillpoint new swing.toml
  stillpoint new linkage.toml --kind linkage";

pub(super) const SCHEMA: &str = "\
Editors complete and check scenario files with it: write it beside them, and begin each with
`#:schema ./scenario.schema.json` (Taplo, Even Better TOML).

Examples:
  stillpoint schema > scenario.schema.json";

pub(super) const COMPLETIONS: &str = "\
Examples:
  stillpoint completions bash > stillpoint.bash
  stillpoint completions zsh > _stillpoint";

pub(super) const MAN: &str = "\
Examples:
  stillpoint man > stillpoint.1
  stillpoint man pages";
