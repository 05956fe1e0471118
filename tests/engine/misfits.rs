//! Lists of wrong lengths, and numbers of unknowns and levels that do not exist, given to the engine's public functions: each is
//! answered, none panics.

use faer::Mat;
use tumble::estimate::{
    Felt, Group, Inequality, Pattern, Restricted, ScatterLine, Settings, System, Whitening, adjust, adjust_scattered,
    restrict,
};

/// The mean of four readings.
fn mean_of_four() -> System {
    System {
        rows: Mat::from_fn(4, 1, |_, _| 1.0),
        observed: vec![1.0, 2.0, 3.0, 4.0],
        u: vec![1.0; 4],
        group: vec![Group::Known; 4],
    }
}

fn line(felt: &[(usize, usize)]) -> ScatterLine {
    ScatterLine {
        felt: felt.iter().map(|(row, level)| Felt { row: *row, level: *level, by: 1.0 }).collect(),
        variance: None,
        memory: None,
    }
}

#[test]
fn constraints_on_an_unknown_that_is_not_there_are_not_applied() {
    let system = mean_of_four();
    let mean = adjust(&system, &Settings::default()).unwrap();
    for far in [1, usize::MAX] {
        let range = Inequality::Range { terms: vec![(0, 1.0), (far, 1.0)], lower: 0.0, upper: 1.0 };
        let norm = Inequality::Norm { of: vec![(far, 0.0)], at_most: 1.0 };
        for inequality in [range, norm] {
            assert!(matches!(restrict(&system, &mean, &[inequality]), Restricted::NotApplied));
        }
    }
}

#[test]
fn a_level_beyond_all_memory_is_an_error() {
    let lines = [line(&[(0, 0), (1, usize::MAX)])];
    let error = adjust_scattered(&mean_of_four(), &lines, None, &[], &Settings::default()).err().unwrap();
    assert!(error.to_string().contains("too many levels"), "{error}");
}

/// What is lacking is not a number in the result, and a line that is not the pattern's changes nothing that the pattern has not.
#[test]
fn whitening_answers_lists_of_other_lengths() {
    let lines = [line(&[(0, 0), (1, 0), (2, 1), (3, 1)])];
    let pattern = Pattern::new(4, &lines);
    let whitening = Whitening::new(&pattern, &[1.0; 4], &lines, &[3.0]);
    for length in [0, 3, 5] {
        let values = vec![1.0; length];
        assert_eq!(whitening.whiten(&values).len(), 4);
        assert_eq!(whitening.carry_back(&values).len(), 4);
        assert_eq!(whitening.whiten(&values).iter().any(|v| v.is_nan()), length < 4);
    }
    // fewer standard deviations than rows, more levels than the pattern has, and lines of another pattern
    assert_eq!(Whitening::new(&pattern, &[1.0; 2], &lines, &[3.0]).whiten(&[1.0; 4]).len(), 4);
    let longer = [line(&[(0, 0), (1, 1), (2, 2), (3, 3)])];
    let crossed = [line(&[(0, 1), (1, 0), (2, 1), (3, 0)])];
    for (other, variance) in [(&longer, 3.0), (&crossed, 3.0), (&longer, -0.1), (&crossed, -0.1)] {
        let whitening = Whitening::new(&pattern, &[1.0; 4], other, &[variance]);
        assert_eq!(whitening.whiten(&[1.0; 4]).len(), 4);
    }
}
