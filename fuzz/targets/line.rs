//! A line of algebra: what is parsed is printed and parsed again alike.
#![no_main]

use tumble::algebra::Expression;

libfuzzer_sys::fuzz_target!(|text: &str| {
    if let Ok(line) = Expression::parse(text) {
        let printed = line.canonical();
        let again = Expression::parse(&printed).expect("what was printed is parsed");
        assert_eq!(again.canonical(), printed);
    }
});
