//! x
#[test]
fn show() {
    let t = std::time::Instant::now();
    let s = stillpoint::scenario::load(std::path::Path::new("/tmp/big50.toml")).unwrap();
    println!("{:?} {}", t.elapsed(), s.description.bodies.len());
    println!(
        "{}",
        std::fs::read_to_string("/proc/self/status").unwrap().lines().find(|l| l.starts_with("VmHWM")).unwrap()
    );
}
