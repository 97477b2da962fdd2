//! First bytes of formats, for readers and writers.

/// Beginning of a MAT file.
pub(crate) const MAT_SIGNATURE: &[u8] = b"MATLAB 5.0 MAT-file";
/// Beginning of an NPY file.
pub(crate) const NPY_SIGNATURE: &[u8] = b"\x93NUMPY";

/// True for a zip archive whose first entry is an array.
pub(crate) fn is_npz(head: &[u8]) -> bool {
    // local file header: length of the name at byte 26, the name from byte 30
    let length = head.get(26..28).map_or(0, |bytes| {
        usize::from(u16::from_le_bytes([bytes[0], bytes[1]]))
    });
    head.starts_with(b"PK\x03\x04")
        && head
            .get(30..30 + length)
            .is_some_and(|name| name.ends_with(b".npy"))
}
