//! No branch and no length of a loop depends on uniforms alone: software Vulkan puts their values into the shader, makes
//! it anew for every draw, and keeps each (docs/decisions/006_software_adapters.md).

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use manypass::shader::compose::PROGRAMS;
use naga::{AddressSpace, Block, Expression, Function, Handle, Module, Statement};
use std::collections::{BTreeSet, HashMap};

/// What an expression is made of, the greatest of its parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    /// Numbers, and values of `override` constants, which are numbers once a pipeline is made.
    Constant,
    /// Uniforms and numbers.
    Uniform,
    /// Something that differs from pixel to pixel, or comes from a texture.
    Varying,
}

/// What is known of a function for kinds of its arguments.
struct Walk<'a> {
    module: &'a Module,
    function: &'a Function,
    arguments: Vec<Kind>,
    results: HashMap<Handle<Expression>, Kind>,
    /// What each variable is given, by how often.
    stores: HashMap<Handle<naga::LocalVariable>, Vec<Handle<Expression>>>,
    found: &'a mut BTreeSet<Place>,
}

/// Where a condition stands, as bytes of the text.
type Place = (usize, usize);

impl Walk<'_> {
    fn kind(&self, at: Handle<Expression>) -> Kind {
        match &self.function.expressions[at] {
            Expression::Literal(_) | Expression::Constant(_) | Expression::Override(_) | Expression::ZeroValue(_) => {
                Kind::Constant
            }
            Expression::FunctionArgument(index) => self.arguments[*index as usize],
            Expression::GlobalVariable(global) => match self.module.global_variables[*global].space {
                AddressSpace::Uniform => Kind::Uniform,
                _ => Kind::Varying,
            },
            Expression::LocalVariable(variable) => self.of_variable(*variable),
            Expression::AccessIndex { base, .. } => self.kind(*base),
            // Numbers once loops are unrolled.
            Expression::Access { base, index } if self.is_counted(*index) => self.kind(*base),
            Expression::Load { pointer } => self.kind(*pointer),
            Expression::Splat { value, .. } => self.kind(*value),
            Expression::Swizzle { vector, .. } => self.kind(*vector),
            Expression::Unary { expr, .. } | Expression::As { expr, .. } => self.kind(*expr),
            Expression::Relational { argument, .. } => self.kind(*argument),
            Expression::Binary { left, right, .. } => self.kind(*left).max(self.kind(*right)),
            Expression::Select { condition, accept, reject } => {
                self.kind(*condition).max(self.kind(*accept)).max(self.kind(*reject))
            }
            Expression::Math { arg, arg1, arg2, arg3, .. } => {
                [Some(*arg), *arg1, *arg2, *arg3].into_iter().flatten().map(|arg| self.kind(arg)).max().unwrap()
            }
            Expression::Compose { components, .. } => {
                components.iter().map(|part| self.kind(*part)).max().unwrap_or(Kind::Constant)
            }
            Expression::CallResult(_) => self.results.get(&at).copied().unwrap_or(Kind::Varying),
            _ => Kind::Varying,
        }
    }

    /// Whether an index is made of numbers and of variables that are given nothing else, such as counters of loops.
    fn is_counted(&self, at: Handle<Expression>) -> bool {
        match &self.function.expressions[at] {
            Expression::Load { pointer } => match &self.function.expressions[*pointer] {
                Expression::LocalVariable(variable) => {
                    let stores = self.stores.get(variable).map_or(&[][..], |stores| &stores[..]);
                    stores.iter().all(|value| match &self.function.expressions[*value] {
                        Expression::Binary { right, .. } => self.kind(*right) == Kind::Constant,
                        _ => self.kind(*value) == Kind::Constant,
                    })
                }
                _ => false,
            },
            Expression::Binary { left, right, .. } => self.is_counted(*left) && self.is_counted(*right),
            _ => self.kind(at) == Kind::Constant,
        }
    }

    /// A variable that is given one value is that value; one that is given several depends on the way there.
    fn of_variable(&self, variable: Handle<naga::LocalVariable>) -> Kind {
        let first = self.function.local_variables[variable].init;
        let stores = self.stores.get(&variable).map_or(&[][..], |stores| &stores[..]);
        match (first, stores) {
            (Some(value), []) => self.kind(value),
            (None, [value]) => self.kind(*value),
            _ => Kind::Varying,
        }
    }

    /// The counter and the bound of `i < bound`, of which a loop ends by.
    fn is_bound_uniform(&self, condition: Handle<Expression>) -> bool {
        let Expression::Binary { left, right, .. } = self.function.expressions[condition] else { return false };
        let is_counter = |at: Handle<Expression>| match self.function.expressions[at] {
            Expression::Load { pointer } => {
                matches!(self.function.expressions[pointer], Expression::LocalVariable(_))
            }
            _ => false,
        };
        is_counter(left) && self.kind(right) == Kind::Uniform
    }

    /// Looks at a block, and gives what it returns.
    fn block(&mut self, block: &Block, returned: &mut Vec<Kind>) {
        for (statement, _) in block.span_iter() {
            match statement {
                Statement::Block(inner) => self.block(inner, returned),
                Statement::If { condition, accept, reject } => {
                    let ends_loop = matches!(reject.first(), Some(Statement::Break));
                    if self.kind(*condition) == Kind::Uniform || (ends_loop && self.is_bound_uniform(*condition)) {
                        let span = self.function.expressions.get_span(*condition).to_range().unwrap_or_default();
                        self.found.insert((span.start, span.end));
                    }
                    self.block(accept, returned);
                    self.block(reject, returned);
                }
                Statement::Switch { selector, cases } => {
                    if self.kind(*selector) == Kind::Uniform {
                        let span = self.function.expressions.get_span(*selector).to_range().unwrap_or_default();
                        self.found.insert((span.start, span.end));
                    }
                    cases.iter().for_each(|case| self.block(&case.body, returned));
                }
                Statement::Loop { body, continuing, .. } => {
                    self.block(body, returned);
                    self.block(continuing, returned);
                }
                Statement::Return { value } => {
                    returned.push(value.map_or(Kind::Constant, |value| self.kind(value)));
                }
                Statement::Call { function, arguments, result } => {
                    let arguments = arguments.iter().map(|argument| self.kind(*argument)).collect();
                    let kind = look(self.module, &self.module.functions[*function], arguments, self.found);
                    if let Some(result) = result {
                        self.results.insert(*result, kind);
                    }
                }
                _ => {}
            }
        }
    }
}

/// All that is stored into variables as a whole.
fn stores(
    function: &Function,
    block: &Block,
    into: &mut HashMap<Handle<naga::LocalVariable>, Vec<Handle<Expression>>>,
) {
    for statement in block {
        match statement {
            Statement::Store { pointer, value } => {
                let mut root = *pointer;
                while let Expression::AccessIndex { base, .. } | Expression::Access { base, .. } =
                    function.expressions[root]
                {
                    root = base;
                }
                if let Expression::LocalVariable(variable) = function.expressions[root] {
                    into.entry(variable).or_default().push(*value);
                }
            }
            Statement::Block(inner) => stores(function, inner, into),
            Statement::If { accept, reject, .. } => {
                stores(function, accept, into);
                stores(function, reject, into);
            }
            Statement::Switch { cases, .. } => cases.iter().for_each(|case| stores(function, &case.body, into)),
            Statement::Loop { body, continuing, .. } => {
                stores(function, body, into);
                stores(function, continuing, into);
            }
            _ => {}
        }
    }
}

/// Looks for branches on uniforms in a function that is called with such arguments; gives the kind of what it returns.
fn look(module: &Module, function: &Function, arguments: Vec<Kind>, found: &mut BTreeSet<Place>) -> Kind {
    let mut of_variables = HashMap::new();
    stores(function, &function.body, &mut of_variables);
    let mut walk = Walk { module, function, arguments, results: HashMap::new(), stores: of_variables, found };
    let mut returned = Vec::new();
    walk.block(&function.body, &mut returned);
    match returned[..] {
        [kind] => kind,
        _ => Kind::Varying,
    }
}

/// The lines of `source` whose branches depend on uniforms alone.
fn faults_of(source: &str) -> BTreeSet<String> {
    let module = naga::front::wgsl::parse_str(source).unwrap();
    let mut found = BTreeSet::new();
    for entry in &module.entry_points {
        look(&module, &entry.function, vec![Kind::Varying; entry.function.arguments.len()], &mut found);
    }
    let line_at = |start: usize| {
        let line = source[..start].rfind('\n').map_or(0, |at| at + 1);
        source[line..].lines().next().unwrap_or_default().trim().to_owned()
    };
    found.into_iter().map(|(start, _)| line_at(start)).collect()
}

#[test]
fn branches_on_uniforms_are_found_wherever_they_stand() {
    let faults = faults_of(
        "struct U { x: f32, n: u32, all: array<vec4f, 4> }
        @group(0) @binding(0) var<uniform> u: U;
        override steps: u32 = 4u;
        fn chosen(is_wide: bool) -> f32 {
            if is_wide { return 2.0; }
            return 1.0;
        }
        @fragment
        fn fs(@builtin(position) position: vec4f) -> @location(0) vec4f {
            var sum = chosen((u.x > 0.5) & (position.x > 0.0));
            for (var i = 0u; i < u.n; i++) { sum += 1.0; }
            for (var i = 0u; i < steps; i++) {
                if u.all[i].x > 0.0 { sum += position.y; }
                if u.all[i].y > position.y { sum += 1.0; }
            }
            switch u.n { case 1u: { sum = 0.0; } default: {} }
            sum += chosen(u.x > 0.5);
            return vec4f(sum);
        }",
    );
    let expected = ["for (var i = 0u; i < u.n", "if u.all[i].x > 0.0", "switch u.n", "chosen(is_wide"];
    for line in expected {
        assert!(faults.iter().any(|fault| fault.contains(line)), "{line} is not among {faults:?}");
    }
    assert_eq!(faults.len(), expected.len(), "{faults:?}");
}

#[test]
fn no_branch_depends_on_uniforms_alone() {
    assert!(PROGRAMS.len() > 30);
    let mut faults = BTreeSet::new();
    for program in PROGRAMS {
        for source in program.modules() {
            faults.extend(faults_of(&source).into_iter().map(|line| format!("{}: {line}", program.name)));
        }
    }
    let lines = faults.iter().cloned().collect::<Vec<_>>().join("\n");
    assert!(faults.is_empty(), "{} branches depend on uniforms alone:\n{lines}", faults.len());
}
