//! Quoting of file names and values in commands that people copy into a shell: each stays one
//! word, and no part of it is run.

use std::ffi::OsStr;
use std::path::Path;

/// The path as one word of a POSIX shell; one that begins with a dash is written `./-…`, so
/// that it is not taken for an option.
pub fn shell_path(path: &Path) -> String {
    let name = path.as_os_str();
    let bytes = name.as_encoded_bytes();
    // a dash alone is standard input
    match bytes.starts_with(b"-") && bytes != b"-" {
        true => shell_word(Path::new(".").join(path)),
        false => shell_word(name),
    }
}

/// The text as one word of a POSIX shell: bare where it holds only letters, digits and a few
/// harmless signs, otherwise in quotes.
pub fn shell_word(text: impl AsRef<OsStr>) -> String {
    let bytes = text.as_ref().as_encoded_bytes();
    let is_bare = |byte: &u8| byte.is_ascii_alphanumeric() || b"_-./,:=+@%".contains(byte);
    match std::str::from_utf8(bytes) {
        Ok(word) if !word.is_empty() && bytes.iter().all(is_bare) => word.to_owned(),
        Ok(word) if !word.contains(char::is_control) => {
            format!("'{}'", word.replace('\'', r"'\''"))
        }
        _ => escaped(bytes),
    }
}

/// The text as `$'...'`, with octal numbers for control characters and for bytes that are not
/// UTF-8.
fn escaped(bytes: &[u8]) -> String {
    let by_number =
        |bytes: &[u8]| -> String { bytes.iter().map(|byte| format!("\\{byte:03o}")).collect() };
    let mut word = String::from("$'");
    for part in bytes.utf8_chunks() {
        for letter in part.valid().chars() {
            match letter {
                '\'' | '\\' => word.extend(['\\', letter]),
                _ if letter.is_control() => {
                    word += &by_number(letter.encode_utf8(&mut [0; 4]).as_bytes());
                }
                _ => word.push(letter),
            }
        }
        word += &by_number(part.invalid());
    }
    word + "'"
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::ffi::OsStrExt;
    use std::process::Command;

    #[test]
    fn a_shell_reads_every_word_as_it_was() {
        let words: [&[u8]; 12] = [
            b"panel.h5",
            b"scans/panel-1.unv",
            b"",
            b"; touch X",
            b"$(touch X)`touch X`",
            b"it's \"quoted\" \\ twice",
            b"two\nlines\tand \x1b[31mred",
            b"-rf",
            b"~",
            b"{a,b} * ? [c] # & | < > ! ",
            "T\u{fc}r \u{85}".as_bytes(),
            b"no text \xff\xfe'9",
        ];
        for word in words {
            let command = format!("printf %s {}", shell_word(OsStr::from_bytes(word)));
            assert!(!command.contains(char::is_control), "{command:?}");
            let said = Command::new("bash")
                .args(["-c", &command])
                .output()
                .unwrap();
            assert_eq!(said.stdout, word, "{command}");
        }
    }

    #[test]
    fn a_path_is_no_option_and_a_plain_one_stays_as_it_is() {
        assert_eq!(shell_path(Path::new("-o")), "./-o");
        assert_eq!(shell_path(Path::new("-")), "-");
        assert_eq!(shell_path(Path::new("a/b.h5")), "a/b.h5");
        assert_eq!(shell_path(Path::new("-; ls")), "'./-; ls'");
    }
}
