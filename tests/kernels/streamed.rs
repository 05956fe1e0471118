//! Where the search for the noise of a record begins: variances of means of 1, 2, 4, ... rows.

#[path = "../../src/fit/streamed/octaves.rs"]
mod octaves;

use octaves::{Octaves, Stated, start};

#[test]
fn pairs_are_disjoint() {
    let mut octaves = Octaves::default();
    [1.0, 3.0, 2.0, 6.0].into_iter().for_each(|x| octaves.push(x));
    let found: Vec<_> = octaves.variances().collect();
    // (1, 3), (2, 6): (4 + 16)/4; means 2 and 4: 4/2
    assert_eq!(found, vec![(1.0, 2, 5.0), (2.0, 1, 2.0)]);
}

/// Variance of half the difference of neighbouring means over `m` rows, from the definition: `w' V w / 2` with weights `-1/m` and `1/m`.
fn by_definition(m: i32, white: f64, deviation: f64, f: f64) -> f64 {
    let weight = |i: i32| if i < m { -1.0 / f64::from(m) } else { 1.0 / f64::from(m) };
    let mut sum = 0.0;
    for i in 0..2 * m {
        for j in 0..2 * m {
            let own = if i == j { white } else { 0.0 };
            sum += weight(i) * weight(j) * (own + deviation * f64::powi(f, (i - j).abs()));
        }
    }
    0.5 * sum
}

/// A series whose variances of means are those of a noise at every length: its differences of means, one for each pair, have the sizes that the
/// definition gives (Haar's basis). The noise comes back, where the grid of the search has it.
#[test]
fn a_noise_with_the_variances_of_its_definition_comes_back() {
    const OCTAVES: usize = 8;
    for (k, ratio, white) in [(6, -4, 1.0), (12, 3, 0.04), (20, 8, 2.5), (26, 0, 1e-6)] {
        let (step, length) = (0.5_f64, 128.0_f64);
        // the grid: 33 times in equal ratios from a third of a step to the length, variances in ratios of 10^(1/4)
        let tau = step / 3.0 * (length / (step / 3.0)).powf(f64::from(k) / 32.0);
        let deviation = white * 10f64.powf(0.25 * f64::from(ratio));
        let f = (-step / tau).exp();
        let mut series = vec![0.0; 1 << OCTAVES];
        for octave in 0..OCTAVES {
            let m = 1_usize << octave;
            let half = (0.5 * by_definition(m as i32, white, deviation, f)).sqrt();
            for (i, value) in series.iter_mut().enumerate() {
                // means of `m` rows differ by twice this
                *value += if (i / m).is_multiple_of(2) { half } else { -half };
            }
        }
        let mut octaves = Octaves::default();
        series.into_iter().for_each(|x| octaves.push(x));
        assert_eq!(octaves.variances().count(), OCTAVES);
        let found = start(&octaves, step, length, Stated::default());
        let near = |own: f64, expected: f64| (own / expected - 1.0).abs() < 1e-6;
        assert!(near(found.tau, tau), "{found:?} for tau {tau}");
        assert!(near(found.white, white.sqrt()) && near(found.deviation, deviation.sqrt()), "{found:?}");
    }
}
