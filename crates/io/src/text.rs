//! Text of files and of command lines, made fit to be shown.

use std::borrow::Cow;

/// Characters of the longest name of a group, and of whatever else a user names.
pub const LONGEST_NAME: usize = 255;

/// Stands for what is not to be shown.
const INSTEAD: char = '\u{fffd}';

/// Whether a character is not seen, but steers what shows it: controls of a terminal, marks and overrides of the direction of
/// writing (Unicode Standard Annex 9, section 2), separators of lines and paragraphs.
pub fn steers(character: char) -> bool {
    let turns =
        matches!(character, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    character.is_control() || turns
}

/// A text without what steers; its lines and tabs stay.
pub fn visible(text: &str) -> Cow<'_, str> {
    let is_fit = |character: char| !steers(character) || matches!(character, '\n' | '\t');
    if text.chars().all(is_fit) {
        return Cow::Borrowed(text);
    }
    let shown = |character| if is_fit(character) { character } else { INSTEAD };
    // the line ends of other systems are line ends, too
    Cow::Owned(text.replace("\r\n", "\n").chars().map(shown).collect())
}

/// A text on one line, without what steers and not longer than a line.
pub fn one_line(text: &str) -> String {
    const LONGEST: usize = 200;
    let shown = |character: char| match character {
        character if character.is_whitespace() => ' ',
        character if steers(character) => INSTEAD,
        character => character,
    };
    let mut line: String = text.chars().take(LONGEST).map(shown).collect();
    if text.chars().nth(LONGEST).is_some() {
        line.push_str("...");
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_steers_a_terminal_is_replaced_and_lines_stay() {
        assert_eq!(visible("a\tb\nµ"), "a\tb\nµ");
        assert_eq!(visible("a\r\nb\rc"), "a\nb\u{fffd}c");
        for hidden in ["\u{1b}[31m", "\u{7}", "\u{7f}", "\u{9b}2J", "\0"] {
            assert!(!visible(hidden).contains(hidden.chars().next().unwrap()), "{hidden:?}");
        }
        let turning = ['\u{61c}', '\u{200e}', '\u{200f}', '\u{2028}', '\u{2029}'];
        for mark in ('\u{202a}'..='\u{202e}').chain('\u{2066}'..='\u{2069}').chain(turning) {
            assert_eq!(visible(&format!("a{mark}b")), "a\u{fffd}b");
        }
    }

    #[test]
    fn a_line_is_one_and_has_an_end() {
        assert_eq!(one_line("one\n\u{1b}[31mtwo\tthree"), "one \u{fffd}[31mtwo three");
        assert_eq!(one_line(&"x".repeat(100_000)).chars().count(), 203);
    }
}
