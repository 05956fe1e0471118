//! Closed vocabularies.

use crate::vocabulary::vocabulary;

vocabulary! {
    /// Where a number comes from.
    Origin {
        /// It was said.
        Stated = "stated",
        /// It was computed.
        AtLast = "at-last",
    }
}

#[test]
fn one_word_for_text_and_json() {
    assert_eq!(serde_json::to_string(&Origin::AtLast).unwrap(), "\"at-last\"");
    assert_eq!(serde_json::from_str::<Origin>("\"stated\"").unwrap(), Origin::Stated);
    assert_eq!((Origin::AtLast.to_string(), Origin::ALL.len()), ("at-last".into(), 2));
    let schema = schemars::schema_for!(Origin).to_value().to_string();
    assert!(schema.contains("\"const\":\"at-last\"") && schema.contains("It was computed."), "{schema}");
    assert!(serde_json::from_str::<Origin>("\"guessed\"").unwrap_err().to_string().contains("at-last"));
}
