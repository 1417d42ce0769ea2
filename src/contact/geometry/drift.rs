//! How a pair of features moves with both solids.

use super::feature::{Feature, Meeting};
use super::{chord, rim};
use nalgebra::Vector3;

/// How velocities of both solids move a pair: rate of its normal in inertial axes, and velocity of its point (m/s).
#[derive(Debug, Clone, Copy)]
pub struct Drift {
    /// ṅ (1/s).
    pub normal: Vector3<f64>,
    /// Velocity of the geometrical point of contact on the first surface (m/s); it moves along both.
    pub point: Vector3<f64>,
    /// Velocities at which core points move along the rims that they are on (m/s).
    slides: [Vector3<f64>; 2],
}

/// The velocity of a material point of a solid: `(velocity of a point, angular velocity)` at an arm from that.
fn material(velocity: &Vector3<f64>, spin: &Vector3<f64>, arm: Vector3<f64>) -> Vector3<f64> {
    velocity + spin.cross(&arm)
}

impl Meeting {
    /// Rates of the pair. `at`, `velocities` and `spins` are points of both bodies (m), their velocities and angular velocities.
    pub fn drift(&self, at: [Vector3<f64>; 2], velocities: [Vector3<f64>; 2], spins: [Vector3<f64>; 2]) -> Drift {
        let bodies = [0, 1].map(|i| material(&velocities[i], &spins[i], self.cores[i] - at[i]));
        let slides = rim::slides(self, bodies, spins);
        let [va, vb] = [bodies[0] + slides[0], bodies[1] + slides[1]];
        let (n, radius) = (self.normal, self.radii[0]);
        let apart = n.dot(&(self.cores[1] - self.cores[0]));
        let across = |x: Vector3<f64>, axis: Vector3<f64>| x - axis * axis.dot(&x);
        // Seen from a solid that carries the direction of an edge, the normal turns with what moves across that edge.
        let about_edge = |carrier: usize, edge: Vector3<f64>| {
            let slip = vb - va;
            // Relative to the carrier's axes.
            let seen = slip - spins[carrier].cross(&(self.cores[1] - self.cores[0]));
            spins[carrier].cross(&n) + across(across(seen, edge), n) / apart
        };
        match self.features {
            [Feature::Face(_), _] => {
                let normal = spins[0].cross(&n);
                // The foot of the second core point on the face.
                let point = vb - (apart - radius) * normal - n * n.dot(&(vb - va));
                Drift { normal, point, slides }
            }
            [_, Feature::Face(_)] => {
                let normal = spins[1].cross(&n);
                Drift { normal, point: va + radius * normal, slides }
            }
            [Feature::Vertex(_), Feature::Vertex(_)] => {
                let normal = across(vb - va, n) / apart;
                Drift { normal, point: va + radius * normal, slides }
            }
            [Feature::Edge(_), Feature::Vertex(_)] => {
                let normal = about_edge(0, self.edges[0]);
                let point = vb - (apart - radius) * normal - n * n.dot(&(vb - va));
                Drift { normal, point, slides }
            }
            [Feature::Vertex(_), Feature::Edge(_)] => {
                let normal = about_edge(1, self.edges[1]);
                Drift { normal, point: va + radius * normal, slides }
            }
            [Feature::Edge(_), Feature::Edge(_)] => {
                let [u, v] = self.edges;
                let turns =
                    |i: usize, e: &Vector3<f64>| spins[i].cross(e) + chord::bends(self.rims[i].as_ref(), &slides[i]);
                if let Some((slides, normal)) = chord::about(self, bodies, spins) {
                    let point = match self.rims[0] {
                        Some(_) => va,
                        None => vb - apart * normal - n * n.dot(&(vb - va)),
                    };
                    return Drift { normal, point: point + radius * normal, slides };
                }
                let crossed = u.cross(&v);
                let normal = chord::turned(self, [turns(0, &u), turns(1, &v)]);
                // The foot on the first edge moves along it by what keeps the line between both feet along n.
                // x_b − x_a = apart n:  v_b + ẏ v − v_a − ẋ u = d(apart) n + apart ṅ
                let slip = bodies[1] - bodies[0] - apart * normal;
                let square = crossed.norm_squared();
                let x = slip.cross(&v).dot(&crossed) / square;
                Drift { normal, point: bodies[0] + x * u + radius * normal, slides }
            }
        }
    }

    /// What velocities add to `g̈` beyond the accelerations of the material core points: with `ν` the rate of the normal
    /// relative to the inertial axes,
    ///
    /// ```text
    /// (3)  g = n·(x_b − x_a),   g̈ = n·(ẍ_b − ẍ_a) + 2 ṅ·(ẋ_b − ẋ_a) + n̈·(x_b − x_a)
    /// ```
    ///
    /// for material points; of a curved pair the points move along the cores, which the second order of the distance has. Points that
    /// move at `s` along a rim add `± s·(ṅ − ω × n)`, the sign that of the body in `g`.
    pub fn bias(
        &self,
        at: [Vector3<f64>; 2],
        velocities: [Vector3<f64>; 2],
        spins: [Vector3<f64>; 2],
        drift: &Drift,
    ) -> f64 {
        let [va, vb] = [0, 1].map(|i| material(&velocities[i], &spins[i], self.cores[i] - at[i]));
        let n = self.normal;
        let apart = n.dot(&(self.cores[1] - self.cores[0]));
        let slide = |i: usize| drift.slides[i].dot(&(drift.normal - spins[i].cross(&n)));
        2.0 * drift.normal.dot(&(vb - va)) - apart * drift.normal.norm_squared() + slide(1) - slide(0)
    }
}
