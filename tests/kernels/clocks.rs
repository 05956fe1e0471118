//! Times of a record: where stretches end, and clocks that were set.

use crate::record::clock::{Clock, JumpKind, Stretch};
use tumble::record::Column;

#[test]
fn stretches_end_at_gaps_also_between_blocks() {
    let column = Column { name: "t".into(), title: "t [ms]".into(), unit: Some("ms".into()) };
    let mut clock = Clock::column(&column, "log.csv").expect("times");
    let found = clock.stretches(Some(&[0.0, 10.0, 20.0, 50.0, 60.0]), 5, None, None).expect("sorted");
    assert_eq!(found, [Stretch { rows: 0..3, after_gap: false }, Stretch { rows: 3..5, after_gap: true }]);
    let found = clock.stretches(Some(&[200.0, 210.0]), 2, None, Some(0.205)).expect("sorted");
    assert_eq!(found, [Stretch { rows: 0..1, after_gap: true }]);
    assert!((clock.interval().expect("steps") - 0.01).abs() < 1e-12 && clock.jumps().1 == 2);
    assert!(clock.stretches(Some(&[100.0]), 1, None, None).is_err());
}

#[test]
fn a_clock_that_was_set_is_told() {
    let column = Column { name: "t".into(), title: "t".into(), unit: None };
    let mut clock = Clock::column(&column, "log.csv").expect("times");
    // 100 Hz; set back by 2.5 s after 500 rows, and by 0.008 s after 800
    let times: Vec<f64> = (0..1000)
        .map(|k| 0.01 * f64::from(k) - if k >= 500 { 2.5 } else { 0.0 } - if k >= 800 { 0.008 } else { 0.0 })
        .collect();
    let found = clock.stretches(Some(&times), times.len(), None, None).expect("nearly sorted");
    assert_eq!(found, [Stretch { rows: 0..500, after_gap: false }, Stretch { rows: 500..1000, after_gap: true }]);
    let (jumps, gaps, others) = clock.jumps();
    assert_eq!((gaps, others), (0, 2));
    assert_eq!((jumps[0].kind, jumps[0].row, jumps[1].kind, jumps[1].row), (JumpKind::Back, 500, JumpKind::Short, 800));
    assert!((jumps[0].step + 2.49).abs() < 1e-9 && (jumps[1].step - 0.002).abs() < 1e-9);
    // the first after the jump stands one interval after the last before it
    assert!((clock.times()[500] - 5.0).abs() < 1e-9);
    assert!(clock.notes().iter().any(|note| note.contains("goes back 1 time")));
}

/// Dates written together are refused, not taken for seconds; numbers of as many digits that are no dates are times.
#[test]
fn dates_without_separators_are_refused() {
    let column = Column { name: "t".into(), title: "t".into(), unit: None };
    let stretches = |times: &[f64]| {
        Clock::column(&column, "log.csv").expect("times").stretches(Some(times), times.len(), None, None)
    };
    let error = stretches(&[20261120091459.0, 20261120091500.0, 20261120091501.0]).expect_err("dates").to_string();
    assert!(error.contains("dates without separators"), "{error}");
    // the month would be 13; seconds 61
    for times in [[20261320091459.0, 20261320091559.0], [20261120091461.0, 20261120091561.0]] {
        assert!(stretches(&times).is_ok());
    }
}
