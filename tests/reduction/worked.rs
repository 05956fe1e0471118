//! Numbers that are known in closed form or worked by hand.

#[test]
fn degrees_of_freedom_of_white_noise() {
    use crate::noise::{Kind, equivalent_dof};
    // white noise, neighbouring differences of 1001 phases: autocorrelations -1/3 and -1/6 in the paper's model, M/(1 + 2 (1/9 + 1/36))
    assert!((equivalent_dof(Kind::Allan, 0, 1, 1001).unwrap() - 782.03).abs() < 0.01);
}

#[test]
fn a_random_walk_in_the_units_of_the_field() {
    use crate::noise::{Term, field_unit};
    let n = field_unit(Term::RandomWalk, "deg/s");
    assert_eq!((n.symbol.as_str(), n.factor), ("deg/sqrt(h)", 60.0));
}

#[test]
fn noise_without_memory() {
    use crate::reduce::{SegmentBlocks, mean_uncertainties};
    // noise without memory: u is s/sqrt(n), nearly
    let mut n = 1_u64;
    let mut next = || {
        n = n.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (n >> 40) as f64 / 16777216.0
    };
    let values: Vec<f64> = (0..2000).map(|_| (0..12).map(|_| next()).sum::<f64>() - 6.0).collect();
    let block =
        SegmentBlocks { pieces: vec![values], length: 2000.0, samples: 2000, sd: 1.0, ..SegmentBlocks::default() };
    let u = mean_uncertainties(&[block], 2000.0, 0.95)[0].u;
    assert!(u > 0.9 / 2000f64.sqrt() && u < 2.0 / 2000f64.sqrt());
}

#[test]
fn an_encoder_goes_on() {
    let mut unwrap = crate::reduce::Unwrap::new(360.0);
    assert_eq!(unwrap.turns(&[270.0, 0.0, 90.0]), [0.75, 1.0, 1.25]);
    assert_eq!(unwrap.turns(&[0.0]), [1.0]);
}
