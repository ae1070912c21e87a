//! Loops of an effect that never end, as far as that shows.

use naga::{Block, Expression, Handle, Literal, Statement};

/// A function whose loops are looked at.
pub(crate) struct Loops<'a> {
    pub module: &'a naga::Module,
    pub function: &'a naga::Function,
}

impl Loops<'_> {
    /// The first loop that nothing leaves.
    pub fn endless(&self) -> Option<naga::Span> {
        self.endless_in(&self.function.body)
    }

    fn endless_in(&self, block: &Block) -> Option<naga::Span> {
        block.span_iter().find_map(|(statement, span)| match statement {
            Statement::Loop { body, continuing, break_if } => {
                let breaks = break_if.is_some_and(|condition| self.value(condition) != Some(false));
                let is_left = breaks || self.leaves(body, true) || self.leaves(continuing, true);
                if is_left { self.endless_in(body).or_else(|| self.endless_in(continuing)) } else { Some(*span) }
            }
            Statement::Block(block) => self.endless_in(block),
            Statement::If { accept, reject, .. } => self.endless_in(accept).or_else(|| self.endless_in(reject)),
            Statement::Switch { cases, .. } => cases.iter().find_map(|case| self.endless_in(&case.body)),
            _ => None,
        })
    }

    /// Whether a block may leave the loop that it stands in, as far as its statements and the conditions that are
    /// literals go. A `break` within a `switch` or another loop leaves that: it counts only if `breaks` does.
    fn leaves(&self, block: &Block, breaks: bool) -> bool {
        block.iter().any(|statement| match statement {
            Statement::Break => breaks,
            Statement::Return { .. } | Statement::Kill => true,
            Statement::Block(block) => self.leaves(block, breaks),
            Statement::If { condition, accept, reject } => match self.value(*condition) {
                Some(true) => self.leaves(accept, breaks),
                Some(false) => self.leaves(reject, breaks),
                None => self.leaves(accept, breaks) || self.leaves(reject, breaks),
            },
            Statement::Switch { cases, .. } => cases.iter().any(|case| self.leaves(&case.body, false)),
            Statement::Loop { body, continuing, .. } => self.leaves(body, false) || self.leaves(continuing, false),
            _ => false,
        })
    }

    /// What a condition always is, where it is a literal, a `const`, or what the parser made one of.
    fn value(&self, condition: Handle<Expression>) -> Option<bool> {
        let literal = |expression: &Expression| match expression {
            Expression::Literal(Literal::Bool(value)) => Some(*value),
            _ => None,
        };
        match &self.function.expressions[condition] {
            Expression::Constant(constant) => {
                literal(&self.module.global_expressions[self.module.constants[*constant].init])
            }
            expression => literal(expression),
        }
    }
}
