//! Loops of an effect that never end, as far as that shows.

/// The first loop of a block that nothing leaves.
pub(super) fn endless_loop(block: &naga::Block) -> Option<naga::Span> {
    use naga::Statement;
    block.span_iter().find_map(|(statement, span)| match statement {
        Statement::Loop { body, continuing, break_if } => {
            let is_left = break_if.is_some() || leaves_loop(body) || leaves_loop(continuing);
            if is_left { endless_loop(body).or_else(|| endless_loop(continuing)) } else { Some(*span) }
        }
        Statement::Block(block) => endless_loop(block),
        Statement::If { accept, reject, .. } => endless_loop(accept).or_else(|| endless_loop(reject)),
        Statement::Switch { cases, .. } => cases.iter().find_map(|case| endless_loop(&case.body)),
        _ => None,
    })
}

/// Whether a block may leave the loop that it stands in, as far as its statements go.
fn leaves_loop(block: &naga::Block) -> bool {
    use naga::Statement;
    // A `break` within a `switch` or another loop leaves that.
    fn returns(block: &naga::Block) -> bool {
        block.iter().any(|statement| match statement {
            Statement::Return { .. } | Statement::Kill => true,
            Statement::Block(block) => returns(block),
            Statement::If { accept, reject, .. } => returns(accept) || returns(reject),
            Statement::Switch { cases, .. } => cases.iter().any(|case| returns(&case.body)),
            Statement::Loop { body, continuing, .. } => returns(body) || returns(continuing),
            _ => false,
        })
    }
    block.iter().any(|statement| match statement {
        Statement::Break | Statement::Return { .. } | Statement::Kill => true,
        Statement::Block(block) => leaves_loop(block),
        Statement::If { accept, reject, .. } => leaves_loop(accept) || leaves_loop(reject),
        Statement::Switch { cases, .. } => cases.iter().any(|case| returns(&case.body)),
        Statement::Loop { body, continuing, .. } => returns(body) || returns(continuing),
        _ => false,
    })
}
