//! Files: read whole up to a stated size, written whole or not at all.

pub mod json;

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::error::{Error, Result};

/// The most that is read of a file of text, bytes. The largest scene that is allowed has half of it.
pub const MAX_TEXT: u64 = 64 << 20;
/// Links in a row that are followed to where a file is to be written.
const MAX_LINKS: usize = 40;

/// The bytes of a file, a pipe or a device, if they are at most `most`.
pub fn read_bytes(path: &Path, most: u64) -> Result<Vec<u8>> {
    let file = File::open(path).map_err(|e| Error::io(path, e))?;
    let about = file.metadata().map_err(|e| Error::io(path, e))?;
    if about.is_dir() {
        return Err(Error::io(path, "is a folder; name a file in it"));
    }
    let mut bytes = Vec::new();
    if about.len() <= most {
        // What grows while it is read, or never ends, has no size to ask for.
        file.take(most + 1).read_to_end(&mut bytes).map_err(|e| Error::io(path, e))?;
    }
    if about.len() > most || bytes.len() as u64 > most {
        return Err(Error::format(path, format!("has more than {most} bytes, the most that is read of such a file")));
    }
    Ok(bytes)
}

/// The text of a file of at most [`MAX_TEXT`] bytes, without a byte order mark.
pub fn read_text(path: impl AsRef<Path>) -> Result<String> {
    let path = path.as_ref();
    text_of(read_bytes(path, MAX_TEXT)?).map_err(|reason| Error::format(path, reason))
}

fn text_of(bytes: Vec<u8>) -> std::result::Result<String, String> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err("is UTF-16; save it as UTF-8".into());
    }
    match String::from_utf8(bytes) {
        Ok(text) => Ok(without_mark(&text).map(str::to_owned).unwrap_or(text)),
        Err(error) => {
            let (good, bad) = error.as_bytes().split_at(error.utf8_error().valid_up_to());
            let (line, column) = json::line_and_column(&String::from_utf8_lossy(good));
            let byte = bad.first().copied().unwrap_or_default();
            Err(format!("byte {byte:#04x} is not UTF-8 (line {line}, column {column})"))
        }
    }
}

/// The text behind a byte order mark, if it begins with one: some editors write it.
pub fn without_mark(text: &str) -> Option<&str> {
    text.strip_prefix('\u{feff}')
}

/// What a path is called where it has no other name: its last part without the ending.
pub fn stem(path: &Path) -> String {
    path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Writes a file: whole, or on failure not at all, so that what was there stays. Links are followed and the mode of a
/// file that was there is kept. What is no file (a pipe, `/dev/stdout`) is written as it is.
pub fn write(path: impl AsRef<Path>, bytes: impl AsRef<[u8]>) -> Result<()> {
    let path = path.as_ref();
    write_with(path, |file| file.write_all(bytes.as_ref())).map_err(|e| Error::io(path, e))
}

fn write_with(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let there = fs::metadata(path).ok();
    if there.as_ref().is_some_and(|there| !there.is_file()) {
        return fill(&mut OpenOptions::new().write(true).open(path)?);
    }
    let place = end_of_links(path)?;
    let folder = match place.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        _ => PathBuf::from("."),
    };
    let part = Part::new(&folder)?;
    let mut file = OpenOptions::new().write(true).create_new(true).open(&part.0)?;
    if let Some(there) = there {
        // A file that must not be changed is not replaced either.
        OpenOptions::new().write(true).open(&place)?;
        file.set_permissions(there.permissions())?;
    }
    fill(&mut file)?;
    file.sync_all()?;
    fs::rename(&part.0, &place)?;
    // The name lasts only when the folder is written too; where folders cannot be opened nothing can be done.
    if let Ok(folder) = File::open(&folder) {
        let _ = folder.sync_all();
    }
    Ok(())
}

/// Where a path leads in the end, also if nothing is there yet.
fn end_of_links(path: &Path) -> io::Result<PathBuf> {
    let mut place = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        match fs::read_link(&place) {
            Ok(next) => place = place.parent().map_or_else(|| next.clone(), |folder| folder.join(&next)),
            Err(_) => return Ok(place),
        }
    }
    Err(io::Error::other("too many links in a row"))
}

/// A file in the making, beside the one that it becomes. It is removed if it did not become one.
struct Part(PathBuf);

impl Part {
    fn new(folder: &Path) -> io::Result<Part> {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let part = folder.join(format!(".jostle-{}-{number}.part", std::process::id()));
        // One that a killed process of the same number left.
        match fs::remove_file(&part) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(Part(part)),
        }
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Folder {
            let folder = std::env::temp_dir().join(format!("jostle-files-{name}-{}", std::process::id()));
            fs::create_dir_all(&folder).unwrap();
            Folder(folder)
        }

        fn names(&self) -> Vec<String> {
            let mut names: Vec<_> =
                fs::read_dir(&self.0).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
            names.sort();
            names
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn a_write_that_fails_leaves_what_was_there() {
        let folder = Folder::new("fails");
        let path = folder.0.join("scene.json");
        for (before, cut) in [(None, 0), (None, 3), (Some("good"), 0), (Some("good"), 3), (Some(""), 1000)] {
            let _ = fs::remove_file(&path);
            if let Some(text) = before {
                fs::write(&path, text).unwrap();
            }
            let failed = write_with(&path, |file| {
                file.write_all(&vec![b'x'; cut])?;
                Err(io::Error::other("the disk is full"))
            });
            assert!(failed.is_err());
            assert_eq!(fs::read_to_string(&path).ok().as_deref(), before, "{cut}");
            assert_eq!(folder.names().len(), usize::from(before.is_some()), "nothing else is left");
            write(&path, "new").unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), "new");
            assert_eq!(folder.names(), ["scene.json"]);
        }
        assert!(matches!(write(folder.0.join("none/scene.json"), "x"), Err(Error::Io { .. })));
        assert!(matches!(write(&folder.0, "x"), Err(Error::Io { .. })), "a folder is no file");
    }

    #[cfg(unix)]
    #[test]
    fn links_modes_and_devices_stay_what_they_are() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = Folder::new("links");
        let (file, link, chain) = (folder.0.join("f"), folder.0.join("link"), folder.0.join("chain"));
        symlink("f", &link).unwrap();
        symlink(&link, &chain).unwrap();
        write(&chain, "through a link to nothing yet").unwrap();
        for mode in [0o600, 0o640, 0o755] {
            fs::set_permissions(&file, fs::Permissions::from_mode(mode)).unwrap();
            write(&chain, format!("{mode}")).unwrap();
            assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, mode);
            assert_eq!(fs::read_to_string(&file).unwrap(), format!("{mode}"));
        }
        assert!(
            fs::symlink_metadata(&link).unwrap().is_symlink() && fs::symlink_metadata(&chain).unwrap().is_symlink()
        );
        symlink("loop", folder.0.join("loop")).unwrap();
        assert!(write(folder.0.join("loop"), "x").is_err());
        write("/dev/null", "x").unwrap();
        assert!(matches!(write("/dev/full", "x"), Err(Error::Io { .. })) || !Path::new("/dev/full").exists());
        assert_eq!(folder.names(), ["chain", "f", "link", "loop"]);
    }

    #[test]
    fn what_is_read_ends_at_the_limit() {
        let folder = Folder::new("limit");
        let path = folder.0.join("f");
        for (size, most) in [(0, 0), (1, 0), (10, 10), (11, 10), (10_000, 9_999)] {
            fs::write(&path, vec![b'x'; size]).unwrap();
            let read = read_bytes(&path, most as u64);
            assert_eq!(read.is_ok(), size <= most, "{size} {most}: {read:?}");
        }
        // Never ends and has no size.
        if Path::new("/dev/zero").exists() {
            let error = read_bytes(Path::new("/dev/zero"), 1 << 20).unwrap_err().to_string();
            assert_eq!(error, "/dev/zero: has more than 1048576 bytes, the most that is read of such a file");
        }
        assert!(read_text(&folder.0).unwrap_err().to_string().ends_with("is a folder; name a file in it"));
    }

    #[test]
    fn text_is_utf_8_with_or_without_a_mark_and_what_is_not_has_its_place() {
        for (bytes, wanted) in [
            (b"a\nb".to_vec(), Ok("a\nb")),
            ("\u{feff}{}".into(), Ok("{}")),
            (vec![], Ok("")),
            (b"\xff\xfea\0".to_vec(), Err("is UTF-16; save it as UTF-8")),
            (b"a\n\xc3\xa4 \xffb".to_vec(), Err("byte 0xff is not UTF-8 (line 2, column 3)")),
            (b"\xc3".to_vec(), Err("byte 0xc3 is not UTF-8 (line 1, column 1)")),
        ] {
            let got = text_of(bytes);
            assert_eq!(got.as_deref().map_err(String::as_str), wanted);
        }
    }
}
