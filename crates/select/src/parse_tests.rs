use super::*;

#[test]
fn wrong_numbers_are_refused() {
    for wrong in ["-1", "NaN", "inf", "", "%", "1%%"] {
        assert!(bound(wrong).is_err(), "{wrong}");
    }
    for wrong in ["1.1", "-0.1", "NaN", "half"] {
        assert!(share(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn sizes_are_shares_or_counts() {
    let cases = [
        ("25%", Target::Ratio(0.25)),
        ("0.25", Target::Ratio(0.25)),
        ("1", Target::Ratio(1.0)),
        ("100%", Target::Ratio(1.0)),
        ("500", Target::Triangles(500)),
        ("10k", Target::Triangles(10_000)),
        ("1.5M", Target::Triangles(1_500_000)),
    ];
    for (text, target) in cases {
        assert_eq!(size(text), Ok(target), "{text}");
    }
    for wrong in ["", "%", "120%", "1.5", "-3", "nan", "k", "ten", "inf"] {
        assert!(size(wrong).is_err(), "{wrong}");
    }
    assert_eq!((share("0"), share("5%"), share("1")), (Ok(0.0), Ok(0.05), Ok(1.0)));
    assert_eq!((count("0"), count("1"), count("2k")), (Ok(0), Ok(1), Ok(2000)));
    assert!(share("10k").is_err_and(|e| e.contains("--triangles")));
    assert!(count("25%").is_err_and(|e| e.contains("a count: 500, 10k")));
}

#[test]
fn percentages_and_lengths_are_distinguished() {
    assert_eq!(bound("0.5%"), Ok(Target::ErrorShare(0.005)));
    assert_eq!(bound(" 0.5"), Ok(Target::Error(0.5)));
}
