//! The streams of indices: triangles, by the edges and vertices that they share with the ones before, and sequences, by
//! differences.

use super::{Stream, StreamError};

/// What the last sixteen entries were.
struct Recent<T> {
    entries: [T; 16],
    pushed: usize,
}

impl<T: Copy + Default> Recent<T> {
    fn new() -> Self {
        Self { entries: [T::default(); 16], pushed: 0 }
    }

    fn push(&mut self, entry: T) {
        self.entries[self.pushed % 16] = entry;
        self.pushed += 1;
    }

    /// The entry that was pushed `age` pushes before the last one.
    fn get(&self, age: u8) -> Result<T, StreamError> {
        let at = self.pushed.checked_sub(1 + usize::from(age));
        let entry = at.filter(|_| age < 16).and_then(|at| self.entries.get(at % 16));
        entry.copied().ok_or(StreamError::Broken("a triangle refers to what was before the first one"))
    }
}

/// A difference with its sign in the lowest bit.
fn signed(value: u32) -> u32 {
    (value >> 1) ^ 0_u32.wrapping_sub(value & 1)
}

fn push_index(indices: &mut Vec<u8>, index: u32, stride: usize) {
    if stride == 2 {
        indices.extend((index as u16).to_le_bytes());
    } else {
        indices.extend(index.to_le_bytes());
    }
}

/// What the decoder of triangles keeps from one to the next.
struct Triangles<'a> {
    extra: Stream<'a>,
    table: &'a [u8],
    edges: Recent<[u32; 2]>,
    vertices: Recent<u32>,
    next: u32,
    last: u32,
}

impl Triangles<'_> {
    fn next_vertex(&mut self) -> u32 {
        let vertex = self.next;
        self.next = self.next.wrapping_add(1);
        vertex
    }

    fn explicit_vertex(&mut self) -> Result<u32, StreamError> {
        self.last = self.last.wrapping_add(signed(self.extra.variable()?));
        Ok(self.last)
    }

    /// A vertex by four bits: the next, a recent or an explicit one; and whether it joins the recent ones.
    fn vertex(&mut self, code: u8) -> Result<(u32, bool), StreamError> {
        match code {
            0 => Ok((self.next_vertex(), true)),
            15 => Ok((self.explicit_vertex()?, true)),
            age => Ok((self.vertices.get(age - 1)?, false)),
        }
    }

    /// A triangle on a recent edge.
    fn on_edge(&mut self, code: u8) -> Result<[u32; 3], StreamError> {
        let [a, b] = self.edges.get(code >> 4)?;
        let (c, is_new) = match code & 15 {
            0 => (self.next_vertex(), true),
            age @ 1..=12 => (self.vertices.get(age)?, false),
            step @ 13..=14 => {
                self.last = if step == 13 { self.last.wrapping_sub(1) } else { self.last.wrapping_add(1) };
                (self.last, true)
            }
            _ => (self.explicit_vertex()?, true),
        };
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        if is_new {
            self.vertices.push(c);
        }
        Ok([a, b, c])
    }

    /// A triangle of three vertices.
    fn alone(&mut self, code: u8) -> Result<[u32; 3], StreamError> {
        let (a, codes) = if code < 0xfe {
            let codes = self.table.get(usize::from(code & 15)).copied().unwrap_or(0);
            (self.next_vertex(), codes)
        } else {
            let codes = self.extra.byte()?;
            if codes == 0 {
                self.next = 0;
            }
            (if code == 0xfe { self.next_vertex() } else { self.explicit_vertex()? }, codes)
        };
        let (b, b_is_new) = self.vertex(codes >> 4)?;
        let (c, c_is_new) = self.vertex(codes & 15)?;
        for edge in [[b, a], [c, b], [a, c]] {
            self.edges.push(edge);
        }
        self.vertices.push(a);
        for (vertex, is_new) in [(b, b_is_new), (c, c_is_new)] {
            if is_new {
                self.vertices.push(vertex);
            }
        }
        Ok([a, b, c])
    }
}

/// `count` indices, a multiple of 3, of `stride` bytes, 2 or 4.
///
/// # Errors
/// If the stream is broken, among others if it has fewer bytes than triangles.
pub(super) fn decode_triangles(data: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, StreamError> {
    let mut stream = Stream(data);
    match stream.byte()? {
        0xe1 => {}
        found => return Err(StreamError::Header { expected: 0xe1, found }),
    }
    let codes = stream.take(count / 3)?;
    let (extra, table) = stream.0.split_at(stream.0.len().checked_sub(16).ok_or(StreamError::Ends)?);
    if table.iter().any(|codes| codes >> 4 == 15 || codes & 15 == 15) {
        return Err(StreamError::Broken("its table of triangles asks for explicit vertices"));
    }
    let mut triangles =
        Triangles { extra: Stream(extra), table, edges: Recent::new(), vertices: Recent::new(), next: 0, last: 0 };
    let mut indices = Vec::with_capacity(codes.len() * 3 * stride);
    for &code in codes {
        let triangle = if code < 0xf0 { triangles.on_edge(code)? } else { triangles.alone(code)? };
        for index in triangle {
            push_index(&mut indices, index, stride);
        }
    }
    triangles.extra.end()?;
    Ok(indices)
}

/// `count` indices of `stride` bytes, 2 or 4.
///
/// # Errors
/// If the stream is broken, among others if it has fewer bytes than indices.
pub(super) fn decode_sequence(data: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, StreamError> {
    let mut stream = Stream(data);
    match stream.byte()? {
        0xd1 => {}
        found => return Err(StreamError::Header { expected: 0xd1, found }),
    }
    let end = stream.0.len().checked_sub(4).ok_or(StreamError::Ends)?;
    let mut stream = Stream(stream.take(end)?);
    if count > end {
        return Err(StreamError::Ends);
    }
    let mut last = [0_u32; 2];
    let mut indices = Vec::with_capacity(count * stride);
    for _ in 0..count {
        let value = stream.variable()?;
        let [first, second] = &mut last;
        let baseline = if value & 1 == 0 { first } else { second };
        *baseline = baseline.wrapping_add(signed(value >> 1));
        push_index(&mut indices, *baseline, stride);
    }
    stream.end()?;
    Ok(indices)
}
