//! What a picture has to know of beams: their elements, by which every point of a centre line follows from the coordinates of a
//! sample, and their sections.

/// A beam as it is drawn.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct BeamPicture {
    /// Name.
    pub name: String,
    /// Index in `Scene::bodies` of the body at whose root marker its first element begins, along x.
    pub begin: usize,
    /// From the root to the tip.
    pub elements: Vec<ElementPicture>,
    /// In ascending order of `at`; between two of them sizes are interpolated.
    pub sections: Vec<SectionPicture>,
}

/// An element of a beam. The coordinates of its strains are those of its body in `Scene::positions`.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct ElementPicture {
    /// Index in `Scene::bodies` of the body at its tip.
    pub body: usize,
    /// Distance of its root from the beam's (m).
    pub from: f64,
    /// Unstrained length (m).
    pub length: f64,
    /// Degree of the strains: 0, 1 or 2.
    pub degree: usize,
    /// Which strains are free: 0 stretch, 1 and 2 shear along y and z, 3 twist, 4 and 5 bending about y and z.
    pub free: Vec<usize>,
    /// Legendre coefficients of the strain without load, constant part first, at most three.
    pub reference: Vec<[f64; 6]>,
}

/// A section of a beam as it is drawn.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct SectionPicture {
    /// Distance from the root (m).
    pub at: f64,
    /// `circle`, `tube`, `rectangle`; or `wire`: no size is known, and it is drawn as a round wire.
    pub kind: String,
    /// Radius; outer and inner radius; width along y and height along z (m).
    pub size: Vec<f64>,
}

/// What is wrong with the beams of a scene that was read: indices lead to bodies, numbers are those of elements.
#[cfg(feature = "record")]
pub(super) fn fault(beams: &[BeamPicture], bodies: usize) -> Option<String> {
    let most = crate::budget::BODIES;
    if beams.iter().map(|beam| beam.elements.len()).sum::<usize>() > most {
        return Some(format!("more than {most} elements of beams"));
    }
    beams.iter().find_map(|beam| {
        let sound = |element: &ElementPicture| {
            element.body < bodies
                && element.degree <= 2
                && (1..=6).contains(&element.free.len())
                && element.free.iter().all(|strain| *strain < 6)
                && element.reference.len() <= 3
                && element.length > 0.0
                && element.length.is_finite()
        };
        let fits = beam.begin < bodies && beam.elements.iter().all(sound);
        (!fits).then(|| format!("an element of the beam `{}` that cannot be", beam.name))
    })
}
