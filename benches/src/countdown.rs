//! Progress of a long run, and the time that it may still take.

use std::time::Instant;

/// Counts pieces of work of about the same size.
pub(crate) struct Countdown<'a> {
    say: &'a dyn Fn(&str),
    start: Instant,
    total: usize,
    begun: usize,
    /// Pieces of this run; those of an earlier one take no time.
    fresh: usize,
}

impl<'a> Countdown<'a> {
    pub(crate) fn new(total: usize, say: &'a dyn Fn(&str)) -> Self {
        Self {
            say,
            start: Instant::now(),
            total,
            begun: 0,
            fresh: 0,
        }
    }

    /// The next piece begins, unless it is `done` already.
    pub(crate) fn next(&mut self, what: &str, done: bool) {
        self.begun += 1;
        if done {
            return;
        }
        let left = self.total - (self.begun - 1).min(self.total);
        let seconds = self.start.elapsed().as_secs_f64() / self.fresh as f64 * left as f64;
        let time = if self.fresh > 0 {
            format!(", {} left", duration(seconds))
        } else {
            String::new()
        };
        (self.say)(&format!("{what} ({} of {}{time})", self.begun, self.total));
        self.fresh += 1;
    }
}

/// Seconds in words, to the precision that a guess has.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    #[test]
    fn only_new_pieces_are_announced_and_timed() {
        let said = RefCell::new(Vec::new());
        let say = |text: &str| said.borrow_mut().push(text.to_owned());
        let mut countdown = Countdown::new(3, &say);
        countdown.next("a", true);
        countdown.next("b", false);
        countdown.next("c", false);
        let said = said.borrow();
        assert_eq!((said.len(), said[0].as_str()), (2, "b (2 of 3)"));
        assert!(
            said[1].starts_with("c (3 of 3, ") && said[1].ends_with("left)"),
            "{said:?}"
        );
        assert_eq!(
            [80.0, 600.0, 7200.0].map(duration),
            ["80 s", "10 min", "2.0 h"]
        );
    }
}
