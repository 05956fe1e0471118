//! Tapes of model lines: what they keep, and many places at a time.

#[path = "../../src/algebra/mod.rs"]
pub(crate) mod whole;

use whole::{Expression, Scratch, Tape};

#[test]
fn numbers_are_worked_out_once_and_only_used_inputs_are_kept() {
    let line = Expression::parse("x*(2*pi/180)^2 + -1").unwrap();
    let tape = Tape::compile(&line, &["unused", "x"]).unwrap();
    assert_eq!(tape.reads(), [1]);
    // the factor and -1 are the constants, a product and a sum the steps
    let shown = format!("{tape:?}");
    let (_, constants) = shown.split_once("constants: [").unwrap();
    let (constants, steps) = constants.split_once("], steps: ").unwrap();
    let factor = (2.0 * std::f64::consts::PI / 180.0).powi(2);
    assert_eq!(constants, format!("{factor:?}, -1.0"));
    assert_eq!((steps.matches("Binary").count(), steps.matches(['N', 'C', 'P']).count()), (2, 0), "{steps}");
}

/// Every operation, at places where some of its branches differ: the same numbers as one place at a time, to the last bit.
#[test]
fn four_places_are_each_by_itself() {
    let lines = [
        "-x + y*x - x/y + x^2*y^3 - x^-2",
        "sin(x)*cos(y) + tan(x) + asin(x/9) - acos(y/9) + atan(x) + sqrt(abs(x)) + sign(y) + exp(x) + step(y)",
        "atan2(x, y) + abs(x)^y + 2^x + x^0",
        "3",
    ];
    let places = [(0.3, -0.2), (2.0, 1.5), (-1.25, 0.5), (0.7, 3.0)];
    for line in lines {
        let tape = Tape::compile(&Expression::parse(line).unwrap(), &["x", "unused", "y"]).unwrap();
        let mut scratch = Scratch::default();
        let inputs = [places.map(|p| p.0), [0.0; 4], places.map(|p| p.1)];
        // names that do not occur get zero
        let mut gradients = [[0.0; 4]; 3];
        let reads = tape.reads();
        let values = tape.gradient_of(|k| inputs[reads[k]], &mut scratch, |k, own| gradients[reads[k]] = *own);
        for (l, (x, y)) in places.into_iter().enumerate() {
            let mut gradient = [f64::NAN; 3];
            let value = tape.gradient(&[x, 0.0, y], &mut scratch, &mut gradient);
            assert_eq!(value, values[l], "{line}");
            assert_eq!(gradient, gradients.map(|g| g[l]), "{line}");
        }
    }
}

/// The same of lists of places.
#[test]
fn many_places_are_each_by_itself() {
    let lines = [
        "-x + y*x - x/y + x^2*y^3 - x^-2 + x*x - x^0",
        "sin(x)*cos(y) + tan(x) + asin(x/9) - acos(y/9) + atan(x) + sqrt(abs(x)) + sign(y) + exp(x) + step(y)",
        "atan2(x, y) + abs(x)^y + 2^x + x^0 + x^0.5 + 0*x/(y - 1.5)",
        "3",
        "y",
    ];
    let places: Vec<(f64, f64)> = (0..45).map(|k| (0.3 * f64::from(k) - 1.25, 1.5 - 0.4 * f64::from(k))).collect();
    for line in lines {
        let tape = Tape::compile(&Expression::parse(line).unwrap(), &["x", "unused", "y"]).unwrap();
        let count = places.len();
        let inputs: Vec<f64> = tape
            .reads()
            .iter()
            .flat_map(|slot| places.iter().map(move |p| if *slot == 0 { p.0 } else { p.1 }))
            .collect();
        let (mut values, mut gradients) = (vec![f64::NAN; count], vec![f64::NAN; tape.reads().len() * count]);
        tape.gradient_of_many(count, &inputs, &mut Scratch::default(), &mut values, &mut gradients);
        let same = |a: f64, b: f64| a == b || (a.is_nan() && b.is_nan());
        for (l, (x, y)) in places.iter().enumerate() {
            let mut gradient = [f64::NAN; 3];
            let value = tape.gradient(&[*x, 0.0, *y], &mut Scratch::default(), &mut gradient);
            assert!(same(value, values[l]), "{line}");
            for (k, slot) in tape.reads().iter().enumerate() {
                assert!(same(gradient[*slot], gradients[k * count + l]), "{line} at {x}, {y}");
            }
        }
    }
}
