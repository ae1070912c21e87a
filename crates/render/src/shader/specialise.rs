//! A module whose constants have values, without what these switch off, so that neither the device nor its driver looks
//! at that.

use super::program::Constant;
use naga::back::pipeline_constants::process_overrides;
use naga::compact::{KeepUnused, compact};
use naga::valid::ModuleInfo;
use naga::{Arena, Block, Expression, Literal, Module, Statement};

/// The module with these values for its `override` constants; others have those that they are declared with. None if a
/// value is none of its constant's type.
pub(super) fn specialised(module: &Module, info: &ModuleInfo, constants: &[Constant]) -> Option<Module> {
    let values = constants.iter().map(|(name, value)| ((*name).to_owned(), f64::from(*value))).collect();
    let (module, _) = process_overrides(module, info, None, &values).ok()?;
    let mut module = module.into_owned();
    let functions = module.functions.iter_mut().map(|(_, function)| function);
    for function in functions.chain(module.entry_points.iter_mut().map(|entry| &mut entry.function)) {
        prune(&mut function.body, &function.expressions);
        // What has a name counts as used.
        function.named_expressions.clear();
    }
    compact(&mut module, KeepUnused::No);
    Some(module)
}

/// Puts in place of every branch whose condition is known what is executed of it.
fn prune(block: &mut Block, expressions: &Arena<Expression>) {
    let statements = std::mem::take(block);
    for (statement, span) in statements.span_into_iter() {
        match statement {
            Statement::If { condition, mut accept, mut reject } => {
                prune(&mut accept, expressions);
                prune(&mut reject, expressions);
                match expressions[condition] {
                    Expression::Literal(Literal::Bool(true)) => block.extend_block(accept),
                    Expression::Literal(Literal::Bool(false)) => block.extend_block(reject),
                    _ => block.push(Statement::If { condition, accept, reject }, span),
                }
            }
            Statement::Block(mut inner) => {
                prune(&mut inner, expressions);
                block.push(Statement::Block(inner), span);
            }
            Statement::Loop { mut body, mut continuing, break_if } => {
                prune(&mut body, expressions);
                prune(&mut continuing, expressions);
                block.push(Statement::Loop { body, continuing, break_if }, span);
            }
            Statement::Switch { selector, mut cases } => {
                cases.iter_mut().for_each(|case| prune(&mut case.body, expressions));
                block.push(Statement::Switch { selector, cases }, span);
            }
            statement => block.push(statement, span),
        }
        // Nothing after it is reached.
        if matches!(block.last(), Some(Statement::Return { .. } | Statement::Break | Statement::Continue)) {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naga::valid::{Capabilities, ValidationFlags, Validator};

    const SOURCE: &str = "
        override masked: u32 = 0u;
        @group(0) @binding(0) var texture: texture_2d<f32>;
        fn alpha(at: vec2i) -> f32 {
            if masked != 0u { return textureLoad(texture, at, 0).a; }
            return 1.0;
        }
        @fragment fn fs(@builtin(position) position: vec4f) -> @location(0) vec4f {
            let alpha = alpha(vec2i(position.xy));
            if masked == 2u { if alpha < 0.5 { discard; } }
            return vec4f(alpha);
        }";

    /// Whether what is left looks at the texture, and whether it discards.
    fn left(masked: u32) -> [bool; 2] {
        let module = naga::front::wgsl::parse_str(SOURCE).unwrap();
        let validate =
            |module: &Module| Validator::new(ValidationFlags::all(), Capabilities::default()).validate(module);
        let info = validate(&module).unwrap();
        let left = specialised(&module, &info, &[("masked", masked)]).unwrap();
        validate(&left).unwrap();
        assert!(left.overrides.is_empty());
        [!left.global_variables.is_empty(), format!("{:?}", left.entry_points[0].function.body).contains("Kill")]
    }

    #[test]
    fn what_is_switched_off_is_gone() {
        assert_eq!(left(0), [false, false]);
        assert_eq!(left(1), [true, false]);
        assert_eq!(left(2), [true, true]);
    }

    #[test]
    fn a_constant_that_is_not_there_makes_no_module() {
        let module = naga::front::wgsl::parse_str(SOURCE).unwrap();
        let info = Validator::new(ValidationFlags::all(), Capabilities::default()).validate(&module).unwrap();
        assert!(specialised(&module, &info, &[("other", 1)]).is_none());
    }

    #[test]
    fn every_built_in_module_stays_valid() {
        for program in super::super::compose::PROGRAMS {
            for source in program.modules() {
                let module = naga::front::wgsl::parse_str(&source).unwrap();
                let info = Validator::new(ValidationFlags::all(), Capabilities::default()).validate(&module).unwrap();
                let left = specialised(&module, &info, &[]).unwrap();
                let checked = Validator::new(ValidationFlags::all(), Capabilities::default()).validate(&left);
                assert!(checked.is_ok(), "{}: {checked:?}", program.name);
            }
        }
    }
}
