//! Tests of the residuals of eight devices side by side.

#[path = "../../src/batch/block.rs"]
mod block;

use crate::quality::{NormalScores, runs};
use block::{LANES, Lane, Sums, network, normality};

/// A network sorts everything if it sorts all sequences of zeros and ones (Knuth, 5.3.4, theorem Z).
#[test]
fn the_network_sorts() {
    for count in 0..13_usize {
        let network = network(count);
        for bits in 0..1_u32 << count {
            let mut values: Vec<u32> = (0..count).map(|k| bits >> k & 1).collect();
            for (i, j) in &network {
                if values[*i] > values[*j] {
                    values.swap(*i, *j);
                }
            }
            assert!(values.is_sorted(), "{count}: {bits:b}");
        }
    }
}

/// Eight devices at once say what each says by itself.
#[test]
fn eight_are_each_by_itself() {
    let number = |i: usize, l: usize| (i * i * 7919 + l * 104_729 + 13) as f64 * 0.618_034 % 2.0 - 1.0;
    let lanes: Vec<Lane> = (0..30).map(|i| std::array::from_fn(|l| number(i, l))).collect();
    let scores = NormalScores::new(30).unwrap();
    let p = normality(&scores, &network(30), &mut lanes.clone());
    let sums = Sums::weighted(&lanes, [[2.0; LANES]; 30].into_iter(), [[1.0; LANES]; 30].into_iter());
    (0..LANES).for_each(|l| {
        let mut own: Vec<f64> = lanes.iter().map(|lane| lane[l]).collect();
        let runs = runs(&own).unwrap().runs;
        assert_eq!(sums.changes[l] + 1.0, runs as f64);
        assert_eq!(sums.positive[l], own.iter().filter(|v| **v > 0.0).count() as f64);
        assert!((sums.squares[l] - own.iter().map(|v| 4.0 * v * v).sum::<f64>()).abs() < 1e-12);
        assert_eq!(p[l], scores.test(&mut own).unwrap().p);
    });
}
