//! Polylines cut to a box, and thinned to the resolution of a screen.

use crate::drawing::Point;

/// The parts of a polyline inside left, top, right, bottom. A point that is not finite breaks
/// the line.
pub(crate) fn clip_line(points: &[Point], sides: [f64; 4]) -> Vec<Vec<Point>> {
    let mut parts: Vec<Vec<Point>> = Vec::new();
    let mut joined = false;
    for pair in points.windows(2) {
        let Some([a, b]) = clip_segment(pair[0], pair[1], sides) else {
            joined = false;
            continue;
        };
        match parts.last_mut() {
            Some(part) if joined && part.last() == Some(&a) => part.push(b),
            _ => parts.push(vec![a, b]),
        }
        joined = b == pair[1];
    }
    parts
}

/// The part of a segment inside the box, by Liang & Barsky, ACM Trans. Graph. 3 (1984) 1.
fn clip_segment(a: Point, b: Point, [left, top, right, bottom]: [f64; 4]) -> Option<[Point; 2]> {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    if !(a[0].is_finite() && a[1].is_finite() && dx.is_finite() && dy.is_finite()) {
        return None;
    }
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    for (step, room) in [
        (-dx, a[0] - left),
        (dx, right - a[0]),
        (-dy, a[1] - top),
        (dy, bottom - a[1]),
    ] {
        if step == 0.0 {
            if room < 0.0 {
                return None;
            }
        } else if step < 0.0 {
            enter = enter.max(room / step);
        } else {
            leave = leave.min(room / step);
        }
    }
    let at = |t: f64| [a[0] + t * dx, a[1] + t * dy];
    (enter <= leave).then(|| {
        [
            if enter > 0.0 { at(enter) } else { a },
            if leave < 1.0 { at(leave) } else { b },
        ]
    })
}

/// Points per px of width beyond which a curve is thinned.
const DENSE: f64 = 4.0;

/// A dense curve with rising x, reduced to the first, lowest, highest and last point of every
/// half px, so that it looks the same. Other curves are unchanged.
pub(crate) fn thinned(points: Vec<Point>) -> Vec<Point> {
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return points;
    };
    let rising = points.windows(2).all(|pair| pair[1][0] >= pair[0][0]);
    if !rising || points.len() as f64 <= DENSE * (last[0] - first[0]).max(1.0) {
        return points;
    }
    let column = |point: &Point| (2.0 * point[0]).floor();
    let mut out: Vec<Point> = Vec::new();
    for group in points.chunk_by(|a, b| column(a) == column(b)) {
        let lowest = (0..group.len())
            .min_by(|&a, &b| group[a][1].total_cmp(&group[b][1]))
            .unwrap_or(0);
        let highest = (0..group.len())
            .max_by(|&a, &b| group[a][1].total_cmp(&group[b][1]))
            .unwrap_or(0);
        let mut keep = vec![0, lowest.min(highest), lowest.max(highest), group.len() - 1];
        keep.dedup();
        out.extend(keep.into_iter().map(|k| group[k]));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_cut_at_the_box_and_broken_at_gaps() {
        let sides = [0.0, 0.0, 10.0, 10.0];
        let parts = clip_line(
            &[
                [-5.0, 5.0],
                [5.0, 5.0],
                [5.0, 15.0],
                [8.0, 15.0],
                [8.0, 5.0],
            ],
            sides,
        );
        assert_eq!(
            parts,
            vec![
                vec![[0.0, 5.0], [5.0, 5.0], [5.0, 10.0]],
                vec![[8.0, 10.0], [8.0, 5.0]]
            ]
        );
        assert_eq!(
            clip_line(
                &[[1.0, 1.0], [2.0, f64::NAN], [3.0, 1.0], [4.0, 1.0]],
                sides
            ),
            vec![vec![[3.0, 1.0], [4.0, 1.0]]]
        );
    }

    #[test]
    fn thinning_keeps_the_peaks() {
        let curve: Vec<Point> = (0..10_000)
            .map(|k| {
                [
                    f64::from(k) / 100.0,
                    if k == 5_001 { -50.0 } else { f64::from(k % 7) },
                ]
            })
            .collect();
        let thin = thinned(curve.clone());
        assert!(
            thin.len() < 1000 && thin.iter().any(|point| point[1] == -50.0),
            "{}",
            thin.len()
        );
        assert_eq!((thin.first(), thin.last()), (curve.first(), curve.last()));
    }
}
