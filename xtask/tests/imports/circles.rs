//! Circles among names of which some import others: in the renderer, folders.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Who imports whom.
pub type Arrows<'a> = BTreeMap<&'a str, BTreeSet<&'a str>>;

/// A shortest way along `arrows` from `start` back to itself; it begins and ends with `start`.
fn circle_of<'a>(arrows: &Arrows<'a>, start: &'a str) -> Option<Vec<&'a str>> {
    let (mut before, mut open) = (BTreeMap::new(), VecDeque::from([start]));
    while let Some(name) = open.pop_front() {
        for next in arrows.get(name).into_iter().flatten() {
            if !before.contains_key(next) {
                before.insert(*next, name);
                open.push_back(next);
            }
        }
    }
    let mut way = vec![start];
    while way.len() < 2 || way.last() != Some(&start) {
        way.push(*before.get(way.last()?)?);
    }
    way.reverse();
    Some(way)
}

/// Shortest circles, until each name that lies in any lies in one of these.
pub fn circles<'a>(arrows: &Arrows<'a>) -> Vec<Vec<&'a str>> {
    let (mut found, mut known) = (Vec::new(), BTreeSet::new());
    for &start in arrows.keys() {
        if !known.contains(start)
            && let Some(circle) = circle_of(arrows, start)
        {
            known.extend(circle.iter().copied());
            found.push(circle);
        }
    }
    found
}
