//! Whether a struct that the CPU fills has the layout of its WGSL twin; for the tests beside each of them.

use super::compose::PROGRAMS;

/// The size of a struct of a program's last variant, and the names and offsets of its members.
pub(crate) fn layout(program: &str, name: &str) -> (u32, Vec<(String, u32)>) {
    let program = PROGRAMS.iter().find(|known| known.name == program).unwrap();
    let module = naga::front::wgsl::parse_str(&program.modules().next_back().unwrap()).unwrap();
    let (_, ty) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name)).unwrap();
    let naga::TypeInner::Struct { members, span } = &ty.inner else { panic!("{name} is not a struct") };
    (*span, members.iter().map(|member| (member.name.clone().unwrap(), member.offset)).collect())
}

/// Asserts that a Rust struct and the WGSL struct of a program have one size, and members of the same names at the same
/// offsets, in the same order.
macro_rules! assert_same_layout {
    ($program:literal, $wgsl:literal, $rust:ty, [$($field:ident),* $(,)?]) => {{
        let (size, members) = crate::shader::layout::layout($program, $wgsl);
        assert_eq!(size as usize, size_of::<$rust>(), "size of {}", $wgsl);
        assert_eq!(size % 16, 0, "WebGL 2 refuses uniforms whose size is not a multiple of 16, such as {}", $wgsl);
        let expected: Vec<(String, u32)> =
            vec![$((stringify!($field).to_owned(), std::mem::offset_of!($rust, $field) as u32)),*];
        assert_eq!(members, expected, "members of {}", $wgsl);
    }};
}

pub(crate) use assert_same_layout;
