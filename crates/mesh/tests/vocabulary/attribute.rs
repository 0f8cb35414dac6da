//! Streams: bytes in, bytes out, and what they mean as numbers.

use lodc_mesh::{Attribute, Component, Semantic};

fn stream(component: Component, components: u8, normalized: bool, bytes: &[u8]) -> Attribute {
    let semantic = Semantic::Custom("_X".to_owned());
    Attribute {
        semantic,
        morph_target: None,
        component,
        components,
        normalized,
        bytes: bytes.to_vec(),
    }
}

#[test]
fn a_stream_knows_its_layout() {
    use Component::{F32, I8, I16, U8, U16, U32};
    for (component, size) in [(I8, 1), (U8, 1), (I16, 2), (U16, 2), (U32, 4), (F32, 4)] {
        let a = stream(component, 3, false, &(0..36).collect::<Vec<u8>>());
        assert_eq!((component.size(), a.stride()), (size, size * 3));
        assert_eq!(a.at(2), (0..36).collect::<Vec<u8>>()[2 * a.stride()..3 * a.stride()].to_vec());
    }
}

#[test]
fn normalised_integers_are_fractions_and_the_lowest_is_minus_one_twice() {
    let value = |component, bytes: &[u8]| stream(component, 1, true, bytes).value(0, 0);
    assert_eq!(value(Component::U8, &[255]), 1.0);
    assert_eq!(value(Component::U8, &[51]), 0.2);
    assert_eq!(value(Component::I8, &[127]), 1.0);
    assert_eq!(value(Component::I8, &[0x81]), -1.0);
    assert_eq!(value(Component::I8, &[0x80]), -1.0);
    assert_eq!(value(Component::I16, &0x7fffu16.to_le_bytes()), 1.0);
    assert_eq!(value(Component::I16, &0x8000u16.to_le_bytes()), -1.0);
    assert_eq!(value(Component::U16, &0xffffu16.to_le_bytes()), 1.0);
    assert_eq!(value(Component::U16, &13107u16.to_le_bytes()), 0.2);
    assert_eq!(value(Component::U32, &u32::MAX.to_le_bytes()), 1.0);
}

#[test]
fn plain_integers_and_floats_are_themselves() {
    let value = |component, bytes: &[u8]| stream(component, 1, false, bytes).value(0, 0);
    assert_eq!(value(Component::U8, &[200]), 200.0);
    assert_eq!(value(Component::I8, &[0x80]), -128.0);
    assert_eq!(value(Component::I16, &(-300i16).to_le_bytes()), -300.0);
    assert_eq!(value(Component::U16, &60_000u16.to_le_bytes()), 60_000.0);
    assert_eq!(value(Component::U32, &70_000u32.to_le_bytes()), 70_000.0);
    assert_eq!(value(Component::F32, &(-1.25f32).to_le_bytes()), -1.25);
    // A float is never scaled, whatever the flag says.
    assert_eq!(stream(Component::F32, 1, true, &7.5f32.to_le_bytes()).value(0, 0), 7.5);
}

#[test]
fn components_are_little_endian_and_in_order() {
    let a = stream(Component::U16, 2, false, &[1, 0, 0, 1, 2, 0, 0, 2]);
    assert_eq!(
        [a.value(0, 0), a.value(0, 1), a.value(1, 0), a.value(1, 1)],
        [1.0, 256.0, 2.0, 512.0]
    );
}

#[test]
fn gathering_copies_bytes_even_of_signalling_nans() {
    let odd = 0x7f80_0001u32.to_le_bytes();
    let a = stream(Component::F32, 1, false, &[odd, [1, 2, 3, 4]].concat());
    let gathered = a.gathered([1, 0, 0].into_iter());
    assert_eq!(gathered.bytes, [[1, 2, 3, 4], odd, odd].concat());
    assert_eq!(gathered.described(), a.described());
}

#[test]
fn what_moves_a_vertex_is_spatial_and_nothing_else() {
    let of = |semantic, morph_target| {
        Attribute { semantic, morph_target, ..stream(Component::F32, 3, false, &[]) }.is_spatial()
    };
    assert!(of(Semantic::Position, None) && of(Semantic::Position, Some(1)));
    assert!(of(Semantic::Joints(1), None) && of(Semantic::Weights(0), None));
    assert!(
        !of(Semantic::Normal, None)
            && !of(Semantic::Normal, Some(0))
            && !of(Semantic::Tangent, Some(0))
    );
    assert!(!of(Semantic::TexCoord(0), None) && !of(Semantic::Color(0), None));
    assert!(!of(Semantic::Custom("POSITION".to_owned()), None));
}
