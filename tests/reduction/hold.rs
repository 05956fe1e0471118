//! What is held while samples come, against the record when it has ended.

use crate::reduce::{Ahead, By, Hold, Look, Trace, reduce, segment};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

const HZ: f64 = 200.0;

/// Two channels: held, moved for three seconds, held for `seconds`.
fn record(seed: u64, seconds: f64) -> Vec<Vec<f64>> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let mut columns = vec![Vec::new(); 2];
    for (level, sd, lasting) in [(0.0, 0.01, 20.0), (0.5, 0.3, 3.0), (1.0, 0.01, seconds)] {
        for _ in 0..(lasting * HZ) as usize {
            columns[0].push(level + sd * normal());
            columns[1].push(-level + sd * normal());
        }
    }
    columns
}

fn held(columns: &[Vec<f64>]) -> (Hold, Look) {
    let names = ["a", "b"].map(|name| (name.to_string(), String::new()));
    let mut hold = Hold::new(names.to_vec(), 2, 0.5, 4.0, 0.5);
    let (rows, mut look) = (hold.rows(1.0 / HZ), Look::Moving);
    for from in (0..columns[0].len()).step_by(rows) {
        let to = (from + rows).min(columns[0].len());
        let times: Vec<f64> = (from..to).map(|row| row as f64 / HZ).collect();
        hold.push(&columns.iter().map(|own| &own[from..to]).collect::<Vec<_>>(), &times, 1.0 / HZ);
        look = hold.look();
    }
    (hold, look)
}

#[test]
fn what_is_held_has_the_mean_of_the_record_that_ended() {
    let columns = record(1, 30.0);
    let (_, look) = held(&columns);
    let Look::Standing(standing) = look else { panic!("{look:?}") };
    let means = standing.means(2, None).unwrap();
    let mut trace = Trace::new(["a", "b"].map(|name| (name.to_string(), String::new())).to_vec());
    trace.interval = 1.0 / HZ;
    trace.push(&columns.iter().map(Vec::as_slice).collect::<Vec<_>>(), None);
    trace.finish();
    let by = By::Still { window: 0.5, threshold: 4.0 };
    let mut found = segment(&trace, &by, 0.5, 1.0);
    found.segments.drain(..found.segments.len() - 1);
    let (start, end) = found.segments[0].span();
    let ended = reduce(&trace, found, &[None]);
    // windows begin where the samples that are kept begin, an eighth of a window apart at most
    let apart = (0.0625 * HZ).ceil() as u64 + 1;
    assert!(standing.start.abs_diff(start) <= apart && standing.end.abs_diff(end) <= apart, "{standing:?}");
    for ((own, _), other) in means.iter().zip(&ended.means[0]) {
        assert!((own.value - other.value).abs() < 0.1 * other.uncertainty.u, "{own:?}\n{other:?}");
        assert!((own.uncertainty.u / other.uncertainty.u - 1.0).abs() < 0.1, "{own:?}\n{other:?}");
    }
    assert!((standing.seconds - (end - start) as f64 / HZ).abs() < 0.2);
}

/// How much longer: for white noise, the samples that are wanted are known.
#[test]
fn how_much_longer_is_foreseen() {
    let mut ratios: Vec<f64> = (0..20)
        .map(|seed| {
            let (_, look) = held(&record(100 + seed, 6.0));
            let Look::Standing(standing) = look else { panic!("{look:?}") };
            let (mean, ahead) = standing.means(2, None).unwrap().swap_remove(0);
            let wanted = 0.01 / (40.0 * HZ).sqrt();
            Ahead::until(standing.seconds, &mean, &ahead, wanted)
                .map_or(f64::INFINITY, |wait| (standing.seconds + wait) / 40.0)
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    // u knows of five seconds what learning the noise costs, which a longer hold pays back
    assert!(ratios[10] > 0.8 && ratios[10] < 3.0, "{ratios:?}");
    let (_, look) = held(&record(1, 6.0));
    let Look::Standing(standing) = look else { panic!("{look:?}") };
    let (mean, ahead) = standing.means(2, None).unwrap().swap_remove(0);
    assert_eq!(Ahead::until(standing.seconds, &mean, &ahead, 1.0), Some(0.0));
    assert_eq!(Ahead::until(standing.seconds, &mean, &ahead, 1e-9), None);
}

#[test]
fn what_moves_is_not_held_and_what_is_known_of_the_still_sensor_stays() {
    let mut columns = record(1, 3.0);
    columns.iter_mut().for_each(|own| own.truncate((22.5 * HZ) as usize));
    let (mut hold, look) = held(&columns);
    assert!(!matches!(look, Look::Standing(_)), "{look:?}");
    // a hand that shakes evenly is no standstill for one who knows what the sensor says at rest
    hold.set_still_sd(vec![0.01; 2]);
    hold.restart();
    let mut random = Pcg64Mcg::seed_from_u64(9);
    let shaken: Vec<f64> = (0..(10.0 * HZ) as usize)
        .map(|_| {
            let own: f64 = StandardNormal.sample(&mut random);
            0.3 * own
        })
        .collect();
    let times: Vec<f64> = (0..shaken.len()).map(|row| 30.0 + row as f64 / HZ).collect();
    let mut unknowing = Hold::new(["a", "b"].map(|name| (name.to_string(), String::new())).to_vec(), 2, 0.5, 4.0, 0.5);
    for own in [&mut hold, &mut unknowing] {
        own.push(&[&shaken[..1000], &shaken[1000..]], &times[..1000], 1.0 / HZ);
    }
    assert!(matches!(hold.look(), Look::Moving));
    assert!(matches!(unknowing.look(), Look::Standing(_)));
}

/// What begins to move, and what has come to rest, is looked at within an eighth of a window (where windows begin) and a glance after a window tells it,
/// whenever it happens between the looks that come anyway; and while nothing changes there are no more looks than those.
#[test]
fn a_change_is_looked_at_when_the_newest_window_tells_it() {
    let (window, glance) = (100, 5);
    for phase in 0..12 {
        let mut random = Pcg64Mcg::seed_from_u64(20 + phase as u64);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let names = ["a", "b"].map(|name| (name.to_string(), String::new()));
        let mut hold = Hold::new(names.to_vec(), 2, 0.5, 4.0, 0.5);
        assert_eq!(hold.rows(1.0 / HZ), glance);
        // a jerk that is too short to forget what was before it
        let (moves, rests) = (1000 + 7 * phase, 1250 + 11 * phase);
        let mut looks = Vec::new();
        for from in (0..2000).step_by(glance) {
            let one = |row: usize, normal: &mut dyn FnMut() -> f64| {
                if (moves..rests).contains(&row) { normal() } else { 0.01 * normal() }
            };
            let columns: Vec<Vec<f64>> =
                (0..2).map(|_| (from..from + glance).map(|row| one(row, &mut normal)).collect()).collect();
            let times: Vec<f64> = (from..from + glance).map(|row| row as f64 / HZ).collect();
            hold.push(&columns.iter().map(Vec::as_slice).collect::<Vec<_>>(), &times, 1.0 / HZ);
            if hold.is_due() {
                hold.look();
                looks.push(from + glance);
            }
        }
        let within = |from: usize, rows: usize| looks.iter().any(|at| (from..=from + rows).contains(at));
        let soon = window / 8 + 2 * glance;
        // one sample that moves is a hundred times the noise
        assert!(within(moves + 1, soon), "{phase}: {looks:?}");
        assert!(within(rests + window - window / 8, window / 4 + soon), "{phase}: {looks:?}");
        let anyway = 2000 / (window / 2);
        assert!(looks.len() <= anyway + 6, "{phase}: {} looks", looks.len());
    }
}
