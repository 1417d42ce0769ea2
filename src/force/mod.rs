//! The kinds of force between points of bodies: one file each, named once in the list below.
//!
//! A kind answers [`Describe`] as a user writes it (its points, its check, its addressable numbers) and [`Act`] once it is
//! compiled (its wrenches and their variation, potential, powers, sizes, picture). [`ForceKind`] and [`Law`] hold one of
//! any kind and pass each question on. What they do in a scene as a whole is in [`crate::dynamics::applied`]; how they are written in
//! files is declared in [`crate::scenario::format`].

mod elastic;
pub mod end;
pub mod lanes;
pub mod question;
mod segment;
pub mod table;
pub mod timeline;

pub use end::{Attachment, Carrier, End, GROUND, Point};
pub use question::{Act, Describe, LineKind, Magnitude, Picture, Report, Switch, Within};

use crate::spatial::Wrench;
use crate::spatial::link::{LinkMotion, LinkVariation};
use nalgebra::Vector3;

/// Something that pushes.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceDescription {
    /// Unique name; scenario files without one get `force[i]`.
    pub name: String,
    /// Its kind.
    pub kind: ForceKind,
}

/// A force, compiled.
#[derive(Debug, Clone)]
pub struct Force {
    /// Name.
    pub name: String,
    /// What it does, and where.
    pub law: Law,
}

impl Force {
    /// A force (N) at a point that keeps its direction in space.
    pub fn dead(name: String, on: End, force: Vector3<f64>) -> Self {
        Self { name, law: Law::Load(load::LoadLaw::dead(on, force)) }
    }
}

macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident in $module:ident),+ $(,)?) => {
        $(pub mod $module;)+
        $(pub use $module::$kind;)+

        /// A force of any kind, as it is described.
        #[derive(Debug, Clone, PartialEq)]
        pub enum ForceKind {
            $($(#[$doc])* $kind($kind),)+
        }

        /// A force of any kind, compiled.
        #[derive(Debug, Clone)]
        pub enum Law {
            $($(#[$doc])* $kind(<$kind as Describe>::Law),)+
        }

        $(impl From<$kind> for ForceKind {
            fn from(kind: $kind) -> Self {
                Self::$kind(kind)
            }
        })+

        impl Describe for ForceKind {
            type Law = Law;

            fn attachments(&self) -> Vec<(String, &Attachment)> {
                match self { $(Self::$kind(kind) => kind.attachments(),)+ }
            }

            fn check(&self, report: &mut Report<'_>) {
                match self { $(Self::$kind(kind) => kind.check(report),)+ }
            }

            fn check_places(&self, places: &[(Option<usize>, Vector3<f64>)], report: &mut Report<'_>) {
                match self { $(Self::$kind(kind) => kind.check_places(places, report),)+ }
            }

            fn compile(&self, carriers: &[Carrier]) -> Law {
                match self { $(Self::$kind(kind) => Law::$kind(kind.compile(carriers)),)+ }
            }

            fn numbers(&self, key: &str) -> Vec<(f64, &'static str)> {
                match self { $(Self::$kind(kind) => kind.numbers(key),)+ }
            }

            fn set(&mut self, key: &str, index: usize, value: f64) {
                match self { $(Self::$kind(kind) => kind.set(key, index, value),)+ }
            }
        }

        impl Act for Law {
            fn ends(&self) -> &[End] {
                match self { $(Self::$kind(law) => law.ends(),)+ }
            }

            fn wrenches(&self, links: &[LinkMotion], give: &mut impl FnMut(usize, Wrench)) {
                match self { $(Self::$kind(law) => law.wrenches(links, give),)+ }
            }

            fn vary(&self, links: &[LinkMotion], by: &[LinkVariation], give: &mut impl FnMut(usize, Wrench)) {
                match self { $(Self::$kind(law) => law.vary(links, by, give),)+ }
            }

            fn vary_each(
                &self,
                links: &[LinkMotion],
                by: &mut [LinkVariation],
                moved: (usize, &[LinkVariation]),
                give: &mut impl FnMut(usize, usize, Wrench),
            ) {
                match self { $(Self::$kind(law) => law.vary_each(links, by, moved, give),)+ }
            }

            fn potential(&self, links: &[LinkMotion]) -> f64 {
                match self { $(Self::$kind(law) => law.potential(links),)+ }
            }

            fn dissipated(&self, links: &[LinkMotion]) -> f64 {
                match self { $(Self::$kind(law) => law.dissipated(links),)+ }
            }

            fn input(&self, links: &[LinkMotion]) -> f64 {
                match self { $(Self::$kind(law) => law.input(links),)+ }
            }

            fn dead(&self) -> Option<(usize, Vector3<f64>)> {
                match self { $(Self::$kind(law) => law.dead(),)+ }
            }

            fn has_potential(&self) -> bool {
                match self { $(Self::$kind(law) => law.has_potential(),)+ }
            }

            fn potential_at_rest(&self, links: &[LinkMotion]) -> f64 {
                match self { $(Self::$kind(law) => law.potential_at_rest(links),)+ }
            }

            fn has_potential_at_rest(&self) -> bool {
                match self { $(Self::$kind(law) => law.has_potential_at_rest(),)+ }
            }

            fn has_damping(&self) -> bool {
                match self { $(Self::$kind(law) => law.has_damping(),)+ }
            }

            fn magnitude(&self, links: &[LinkMotion]) -> Magnitude {
                match self { $(Self::$kind(law) => law.magnitude(links),)+ }
            }

            fn not_finite(&self, links: &[LinkMotion]) -> Option<&'static str> {
                match self { $(Self::$kind(law) => law.not_finite(links),)+ }
            }

            fn in_one_place(&self, links: &[LinkMotion], within: f64) -> bool {
                match self { $(Self::$kind(law) => law.in_one_place(links, within),)+ }
            }

            fn switches(&self) -> Option<[&'static str; 2]> {
                match self { $(Self::$kind(law) => law.switches(),)+ }
            }

            fn is_uneven(&self) -> bool {
                match self { $(Self::$kind(law) => law.is_uneven(),)+ }
            }

            fn boundaries(&self) -> [Option<usize>; 4] {
                match self { $(Self::$kind(law) => law.boundaries(),)+ }
            }

            fn switch(&self, boundary: usize, links: &[LinkMotion]) -> Switch {
                match self { $(Self::$kind(law) => law.switch(boundary, links),)+ }
            }

            fn keep(&mut self, links: &[LinkMotion]) {
                match self { $(Self::$kind(law) => law.keep(links),)+ }
            }

            fn side(&self, boundary: usize) -> bool {
                match self { $(Self::$kind(law) => law.side(boundary),)+ }
            }

            fn cross(&mut self, boundary: usize) {
                match self { $(Self::$kind(law) => law.cross(boundary),)+ }
            }

            fn steady_until(&self) -> f64 {
                match self { $(Self::$kind(law) => law.steady_until(),)+ }
            }

            fn times(&self) -> &[f64] {
                match self { $(Self::$kind(law) => law.times(),)+ }
            }

            fn set_time(&mut self, time: f64) {
                match self { $(Self::$kind(law) => law.set_time(time),)+ }
            }

            fn pull_name(&self) -> Option<&'static str> {
                match self { $(Self::$kind(law) => law.pull_name(),)+ }
            }

            fn is_line(&self) -> bool {
                match self { $(Self::$kind(law) => law.is_line(),)+ }
            }

            fn pull(&self, links: &[LinkMotion]) -> f64 {
                match self { $(Self::$kind(law) => law.pull(links),)+ }
            }

            fn length(&self, links: &[LinkMotion]) -> f64 {
                match self { $(Self::$kind(law) => law.length(links),)+ }
            }

            fn vary_line(&self, links: &[LinkMotion], by: &[LinkVariation]) -> [f64; 2] {
                match self { $(Self::$kind(law) => law.vary_line(links, by),)+ }
            }

            fn within(&self, tip: usize, links: &[LinkMotion]) -> Option<Within> {
                match self { $(Self::$kind(law) => law.within(tip, links),)+ }
            }

            fn picture(&self) -> Picture<'_> {
                match self { $(Self::$kind(law) => law.picture(),)+ }
            }
        }
    };
}

kinds! {
    /// Along the line between two points.
    Spring in spring,
    /// Spring and damper in six directions.
    Bushing in bushing,
    /// A constant force and torque.
    Load in load,
    /// Pulls along a path through points.
    Rope in rope,
    /// By tables along the line between two points.
    Curve in curve,
    /// Presses a point onto the axis of a beam, along which it slides.
    Slider in slider,
}
