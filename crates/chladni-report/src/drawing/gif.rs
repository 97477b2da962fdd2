//! Moving pictures: GIF89a with one palette of 256 colours, run for ever.

use std::collections::HashMap;

/// Bits of a pixel, and of the first codes.
const BITS: u32 = 8;
/// Code that empties the table, and the one that ends a picture.
const CLEAR: u16 = 1 << BITS;
const END: u16 = CLEAR + 1;
/// Most codes of the table.
const MOST: u16 = 4096;
/// Most bytes of a block.
const BLOCK: usize = 255;

/// Pictures of `width` × `height` px, row by row from the top, as numbers of `palette`;
/// `delay_cs` hundredths of a second each.
pub(crate) fn gif(
    [width, height]: [u16; 2],
    palette: &[[u8; 3]; 256],
    frames: &[Vec<u8>],
    delay_cs: u16,
) -> Vec<u8> {
    let mut out = b"GIF89a".to_vec();
    let size = [width.to_le_bytes(), height.to_le_bytes()].concat();
    out.extend(&size);
    // a palette for all pictures, of 2⁸ colours with 8 bits each
    out.extend([0xF7, 0, 0]);
    out.extend(palette.as_flattened());
    out.extend(b"\x21\xFF\x0BNETSCAPE2.0\x03\x01\x00\x00\x00");
    for frame in frames {
        let [low, high] = delay_cs.to_le_bytes();
        out.extend([0x21, 0xF9, 4, 0, low, high, 0, 0]);
        out.extend([0x2C, 0, 0, 0, 0]);
        out.extend(&size);
        out.extend([0, BITS as u8]);
        for block in packed(frame).chunks(BLOCK) {
            out.push(block.len() as u8);
            out.extend(block);
        }
        out.push(0);
    }
    out.push(0x3B);
    out
}

/// The pixels by the algorithm of Lempel, Ziv and Welch, the lowest bits first.
fn packed(pixels: &[u8]) -> Vec<u8> {
    let mut bits = Bits::default();
    let mut table: HashMap<(u16, u8), u16> = HashMap::new();
    let (mut next, mut width) = (END + 1, BITS + 1);
    bits.push(CLEAR, width);
    let mut rest = pixels.iter();
    let Some(&first) = rest.next() else {
        bits.push(END, width);
        return bits.done();
    };
    let mut known = u16::from(first);
    for &pixel in rest {
        if let Some(&longer) = table.get(&(known, pixel)) {
            known = longer;
            continue;
        }
        bits.push(known, width);
        if next < MOST {
            table.insert((known, pixel), next);
            width += u32::from(next == 1 << width);
            next += 1;
        } else {
            bits.push(CLEAR, width);
            table.clear();
            (next, width) = (END + 1, BITS + 1);
        }
        known = u16::from(pixel);
    }
    bits.push(known, width);
    // a reader has made one more code by now
    width += u32::from(next == 1 << width && next < MOST);
    bits.push(END, width);
    bits.done()
}

#[derive(Default)]
struct Bits {
    bytes: Vec<u8>,
    waiting: u32,
    count: u32,
}

impl Bits {
    fn push(&mut self, code: u16, width: u32) {
        self.waiting |= u32::from(code) << self.count;
        self.count += width;
        while self.count >= 8 {
            self.bytes.push(self.waiting as u8);
            self.waiting >>= 8;
            self.count -= 8;
        }
    }

    fn done(mut self) -> Vec<u8> {
        if self.count > 0 {
            self.bytes.push(self.waiting as u8);
        }
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The slow and obvious way back.
    fn unpacked(bytes: &[u8]) -> Vec<u8> {
        let mut at = 0;
        let mut code = |width: usize| -> usize {
            let bit = |k: usize| usize::from(bytes[(at + k) / 8] >> ((at + k) % 8) & 1) << k;
            let found = (0..width).map(bit).sum();
            at += width;
            found
        };
        let fresh = || -> Vec<Vec<u8>> {
            let one = |k: u16| if k < CLEAR { vec![k as u8] } else { Vec::new() };
            (0..=END).map(one).collect()
        };
        let (mut table, mut out, mut before) = (fresh(), Vec::new(), None::<Vec<u8>>);
        loop {
            let mut width = 9;
            while table.len() + usize::from(before.is_some()) > 1 << width && width < 12 {
                width += 1;
            }
            let found = code(width);
            if found == usize::from(END) {
                return out;
            }
            if found == usize::from(CLEAR) {
                (table, before) = (fresh(), None);
                continue;
            }
            let word = match (&before, table.get(found)) {
                (_, Some(word)) => word.clone(),
                (Some(before), None) => [before.as_slice(), &before[..1]].concat(),
                (None, None) => panic!("code {found} of {}", table.len()),
            };
            if let Some(mut before) = before.take() {
                before.push(word[0]);
                if table.len() < usize::from(MOST) {
                    table.push(before);
                }
            }
            out.extend(&word);
            before = Some(word);
        }
    }

    #[test]
    fn pixels_come_back() {
        let mut seed = 1u32;
        let mut noise = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 24) as u8
        };
        for pixels in [
            vec![7; 1],
            vec![7; 5000],
            (0..3000).map(|k| (k / 50) as u8).collect(),
            // many more codes than the table holds
            (0..40_000).map(|_| noise()).collect::<Vec<u8>>(),
        ] {
            assert!(unpacked(&packed(&pixels)) == pixels, "{} px", pixels.len());
        }
    }
}
