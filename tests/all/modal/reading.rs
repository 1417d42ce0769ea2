//! Files of finite elements: what is taken, what is refused and with which words.

use super::{Strip, lattice};
use stillpoint::fem::{FiniteElements, ModalDamping, Symmetric};

/// Names of an archive's members, and what is in them.
type Members = Vec<(&'static str, Vec<u8>)>;

/// A model with something wrong with it, and a part of what is said.
fn refused(change: impl Fn(&mut FiniteElements), words: &[&str]) {
    let mut model = Strip::unit(3).model(&[0, 3], false);
    change(&mut model);
    let flaw = model.reduce(0, ModalDamping::None).expect_err("something is wrong");
    let told = format!("{flaw} {}", flaw.help.as_deref().unwrap_or_default());
    assert!(words.iter().all(|word| told.contains(word)), "{told}");
}

fn changed(matrix: &Symmetric, change: impl Fn(usize, usize, f64) -> f64) -> Symmetric {
    let entries = matrix.entries().map(|(i, j, x)| (i, j, change(i, j, x)));
    Symmetric::of("matrix", matrix.len(), entries, |row| row.to_string()).expect("symmetric")
}

#[test]
fn flaws_are_told_with_names_and_values() {
    refused(
        |model| model.stiffness = changed(&model.stiffness, |i, j, x| if i == 14 && j == 14 { x + 1.0 } else { x }),
        &["the stiffness resists", "node 2 z"],
    );
    refused(|model| model.nodes[3].y = 0.1, &["the stiffness resists a turn", "units and axes"]);
    refused(
        |model| model.mass = changed(&model.mass, |i, j, x| if i % 6 == 1 && j % 6 == 1 { 2.0 * x } else { x }),
        &["kg along x"],
    );
    refused(|model| model.interfaces[1].nodes = vec![7], &["`p1`", "node 7 of 4"]);
    refused(|model| model.interfaces[1].nodes = vec![0], &["node 0 belongs to", "`root`"]);
    refused(|model| model.interfaces[1].nodes.clear(), &["`p1`", "a node with six freedoms"]);
    refused(|model| model.declared.mass = Some(2.0), &["the mass is 1.0", "declared are 2.0"]);
    refused(|model| model.freedoms[5] = model.freedoms[4], &["row 5", "already"]);
}

#[test]
fn two_nodes_in_a_line_are_no_interface() {
    let mut model = lattice(&[1.0; 9]);
    model.interfaces[1].nodes.pop();
    let flaw = model.reduce(0, ModalDamping::None).expect_err("a line of two nodes");
    assert!(flaw.message.contains("is not one of its 2 nodes"), "{flaw}");
}

#[test]
fn a_matrix_that_is_not_symmetric_is_refused() {
    let entries = [(0, 0, 1.0), (1, 1, 1.0), (0, 1, 0.5), (1, 0, 0.6)];
    let flaw = Symmetric::of("stiffness", 2, entries, |row| format!("row {row}")).expect_err("two triangles");
    assert!(flaw.message.contains("row 0 against row 1 has 5e-1, its mirror 6e-1"), "{flaw}");
}

#[cfg(feature = "import")]
mod files {
    use stillpoint::fem::npz;

    /// A zip archive without compression: headers of each member, then the directory.
    fn archive(members: &[(&str, Vec<u8>)]) -> Vec<u8> {
        let (mut out, mut directory) = (Vec::new(), Vec::new());
        for (name, bytes) in members {
            let name = format!("{name}.npy");
            let crc = crc32(bytes);
            let offset = out.len() as u32;
            let common = |list: &mut Vec<u8>| {
                list.extend([20, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
                list.extend(crc.to_le_bytes());
                list.extend((bytes.len() as u32).to_le_bytes());
                list.extend((bytes.len() as u32).to_le_bytes());
                list.extend((name.len() as u16).to_le_bytes());
                list.extend([0, 0]);
            };
            out.extend(b"PK\x03\x04");
            common(&mut out);
            out.extend(name.bytes());
            out.extend(bytes);
            directory.extend(b"PK\x01\x02\x14\x00");
            common(&mut directory);
            directory.extend([0; 10]);
            directory.extend(offset.to_le_bytes());
            directory.extend(name.bytes());
        }
        let start = out.len() as u32;
        let size = directory.len() as u32;
        out.extend(directory);
        out.extend(b"PK\x05\x06\0\0\0\0");
        out.extend((members.len() as u16).to_le_bytes());
        out.extend((members.len() as u16).to_le_bytes());
        out.extend(size.to_le_bytes());
        out.extend(start.to_le_bytes());
        out.extend([0, 0]);
        out
    }

    fn crc32(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0_u32, |crc, byte| {
            (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg()))
        })
    }

    fn array(kind: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({shape}), }}");
        while (header.len() + 11) % 64 != 0 {
            header.push(' ');
        }
        header.push('\n');
        let mut out = b"\x93NUMPY\x01\x00".to_vec();
        out.extend((header.len() as u16).to_le_bytes());
        out.extend(header.bytes());
        out.extend(data);
        out
    }

    fn numbers(shape: &str, list: &[f64]) -> Vec<u8> {
        array("<f8", shape, &list.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>())
    }

    /// A bar of two nodes with six freedoms each, without any stiffness.
    fn members() -> Vec<(&'static str, Vec<u8>)> {
        let whole: Vec<u8> = (0..12_i64).flat_map(|row| [row / 6, row % 6]).flat_map(i64::to_le_bytes).collect();
        let text: Vec<u8> = "rootp1\0\0".chars().flat_map(|c| (c as u32).to_le_bytes()).collect();
        let identity: Vec<f64> = (0..144).map(|at| f64::from(u8::from(at % 13 == 0))).collect();
        vec![
            ("nodes", numbers("2, 3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0])),
            ("dofs", array("<i8", "12, 2", &whole)),
            ("mass", numbers("12, 12", &identity)),
            ("stiffness", numbers("12, 12", &[0.0; 144])),
            ("interface_names", array("<U4", "2,", &text)),
            ("interface_points", numbers("2, 3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0])),
            ("interface_nodes", array("|u1", "2, 2", &[0, 0, 1, 1])),
        ]
    }

    #[test]
    fn arrays_of_numpy_are_read() {
        let model = npz::read(&archive(&members())).expect("sound");
        assert_eq!((model.nodes.len(), model.freedoms.len()), (2, 12));
        assert_eq!(model.interfaces.iter().map(|one| one.name.as_str()).collect::<Vec<_>>(), ["root", "p1"]);
        assert_eq!(model.mass.entries().filter(|(_, _, x)| *x != 0.0).count(), 12);
    }

    #[test]
    fn what_is_missing_or_misspelt_is_named() {
        let told = |change: &dyn Fn(&mut super::Members)| {
            let mut all = members();
            change(&mut all);
            let flaw = npz::read(&archive(&all)).expect_err("something is wrong");
            format!("{flaw} {}", flaw.help.clone().unwrap_or_default())
        };
        assert!(told(&|all| all[0].0 = "node").contains("unknown array `node` did you mean `nodes`?"));
        assert!(told(&|all| all.truncate(6)).contains("no array `interface_nodes`"));
        assert!(told(&|all| all[0].1.truncate(100)).contains("`nodes`"));
        assert!(told(&|all| all[3].1 = numbers("2, 2", &[0.0; 4])).contains("it needs 12×12"));
        assert!(npz::read(b"PK").expect_err("no archive").message.contains("not an archive"));
    }
}
