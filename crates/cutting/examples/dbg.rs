//! dbg
#[path = "../tests/random_cuts/bodies.rs"]
mod bodies;
#[path = "../src/testing.rs"]
mod random;
#[path = "../tests/random_cuts/soak.rs"]
mod soak;
fn main() {
    let seed = std::env::args().nth(1).unwrap().parse().unwrap();
    let mut s = soak::Summary::default();
    println!("{:?}", soak::cut_body(seed, &mut s));
}
