use super::*;

#[test]
fn wrong_numbers_are_refused() {
    for wrong in ["-1", "NaN", "inf", "", "%", "1%%"] {
        assert!(bound(wrong).is_err(), "{wrong}");
    }
    for wrong in ["1.1", "-0.1", "NaN", "half"] {
        assert!(ratio(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn percentages_and_lengths_are_distinguished() {
    assert_eq!(bound("0.5%"), Ok(Target::ErrorShare(0.005)));
    assert_eq!(bound(" 0.5"), Ok(Target::Error(0.5)));
}
