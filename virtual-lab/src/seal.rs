//! Sealed answers: encrypted and authenticated (XChaCha20-Poly1305), so that they can be neither read nor changed
//! without the key.

use base64::prelude::{BASE64_STANDARD, Engine};
use chacha20poly1305::aead::{Aead, Generate, Key as CipherKey, KeyInit};
use chacha20poly1305::{XChaCha20Poly1305, XNonce};
use files::input::{measured, quoted_near};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use thiserror::Error;

use files::sha256;

/// Value of the seal's `format` key.
pub const SEAL_FORMAT: &str = "robofin-seal/1";
/// The only cipher.
const CIPHER: &str = "XChaCha20-Poly1305";
/// Plain texts are padded with spaces to a multiple of this, so that their length reveals nothing.
const BLOCK: usize = 1 << 15;

/// The key of a seal.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Key([u8; 32]);

/// A sealed answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Seal {
    format: String,
    cipher: String,
    /// 24 bytes in hexadecimal digits.
    nonce: String,
    /// Ciphertext in Base64.
    ciphertext: String,
    /// SHA-256 of the padded plain text, in hexadecimal digits: a commitment to the answer before it is opened.
    sha256: String,
}

/// Reason for which a seal does not open.
#[derive(Debug, Error, PartialEq, Eq)]
pub enum SealError {
    /// The key file holds something else.
    #[error("{found} is not a key: 64 hexadecimal digits are expected")]
    NoKey {
        /// Description of the contents by their length; a key is never repeated.
        found: String,
    },
    /// The seal has another format.
    #[error("{name} is {found}: {accepted:?} is expected")]
    Format {
        /// Name of the JSON key.
        name: &'static str,
        /// Value found.
        found: String,
        /// Value accepted.
        accepted: String,
    },
    /// The key is wrong, or bytes were changed.
    #[error("this key does not open it: it is the key of another seal, or the seal was changed")]
    WrongKey,
    /// The contents differ from the commitment of the seal.
    #[error("the contents have the SHA-256 {found}, and the seal says {expected}")]
    WrongHash {
        /// SHA-256 of the contents.
        found: String,
        /// SHA-256 in the seal.
        expected: String,
    },
}

impl Key {
    /// Most bytes of a key file: its digits and surrounding white space.
    pub const MOST_BYTES: u64 = 1024;

    /// A random key.
    pub fn random() -> Self {
        Self(CipherKey::<XChaCha20Poly1305>::generate().into())
    }

    /// The key of a seed; it is as hard to guess as the seed.
    pub fn of_seed(seed: u64) -> Self {
        Self(Sha256::new().chain_update("robofin seal").chain_update(seed.to_le_bytes()).finalize().into())
    }

    /// Text of a key file.
    pub fn text(&self) -> String {
        hex(&self.0) + "\n"
    }

    /// Reads a key file.
    ///
    /// # Errors
    /// [`SealError::NoKey`].
    pub fn parse(text: &str) -> Result<Self, SealError> {
        let no_key = || SealError::NoKey { found: measured(text.trim()) };
        from_hex(text.trim()).and_then(|bytes| bytes.try_into().ok()).map(Self).ok_or_else(no_key)
    }
}

impl Seal {
    /// Seals a text.
    pub fn new(text: &str, key: Key) -> Self {
        // One key seals one text, so the nonce may be derived from both.
        let digest = Sha256::new().chain_update(key.0).chain_update(text).finalize();
        let mut padded = text.as_bytes().to_vec();
        padded.push(b'\n');
        // Without a secret random word, a guess of the whole answer could be tested against the hash.
        padded.extend_from_slice(hex(&Sha256::digest([digest.as_slice(), &key.0].concat())).as_bytes());
        padded.resize(padded.len().next_multiple_of(BLOCK), b' ');
        let mut nonce = [0; 24];
        nonce.copy_from_slice(&digest[..24]);
        let cipher = XChaCha20Poly1305::new(&key.0.into());
        let ciphertext =
            cipher.encrypt(&XNonce::from(nonce), padded.as_slice()).expect("a text that fits in memory can be sealed");
        Self {
            format: SEAL_FORMAT.to_owned(),
            cipher: CIPHER.to_owned(),
            nonce: hex(&nonce),
            ciphertext: BASE64_STANDARD.encode(ciphertext),
            sha256: sha256(&padded),
        }
    }

    /// Opens a seal and checks its contents against the commitment.
    ///
    /// # Errors
    /// [`SealError`] for another key, changed bytes, or another format.
    pub fn open(&self, key: Key) -> Result<String, SealError> {
        for (name, found, accepted) in [("format", &self.format, SEAL_FORMAT), ("cipher", &self.cipher, CIPHER)] {
            if found != accepted {
                return Err(SealError::Format {
                    name,
                    found: quoted_near(found, [accepted]),
                    accepted: accepted.to_owned(),
                });
            }
        }
        let nonce: [u8; 24] =
            from_hex(&self.nonce).and_then(|bytes| bytes.try_into().ok()).ok_or(SealError::WrongKey)?;
        let ciphertext = BASE64_STANDARD.decode(&self.ciphertext).map_err(|_| SealError::WrongKey)?;
        let cipher = XChaCha20Poly1305::new(&key.0.into());
        let padded = cipher.decrypt(&XNonce::from(nonce), ciphertext.as_slice()).map_err(|_| SealError::WrongKey)?;
        let found = sha256(&padded);
        if found != self.sha256 {
            return Err(SealError::WrongHash { found, expected: self.sha256.clone() });
        }
        let text = String::from_utf8(padded).map_err(|_| SealError::WrongKey)?;
        let (text, _) = text.trim_end().rsplit_once('\n').ok_or(SealError::WrongKey)?;
        Ok(text.to_owned())
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn from_hex(text: &str) -> Option<Vec<u8>> {
    let pairs = text.is_ascii() && text.len().is_multiple_of(2);
    let byte = |at: usize| u8::from_str_radix(&text[at..at + 2], 16).ok();
    pairs.then(|| (0..text.len()).step_by(2).map(byte).collect())?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seal_opens_with_its_key_only_and_not_once_changed() {
        let (key, other) = (Key::of_seed(7), Key::random());
        let seal = Seal::new("{\"effects\": []}", key);
        assert_eq!(seal.open(key).unwrap(), "{\"effects\": []}");
        assert_eq!(seal.open(other), Err(SealError::WrongKey));
        assert_eq!(Key::parse(&key.text()).unwrap().0, key.0);
        let longer = Seal::new(&"x".repeat(BLOCK / 2), key);
        assert_eq!(seal.ciphertext.len(), longer.ciphertext.len());
        assert_ne!(seal.nonce, longer.nonce);
        let changed = Seal { ciphertext: longer.ciphertext.clone(), ..seal.clone() };
        assert_eq!(changed.open(key), Err(SealError::WrongKey));
        let changed = Seal { sha256: longer.sha256, ..seal.clone() };
        assert!(matches!(changed.open(key), Err(SealError::WrongHash { .. })));
        let changed = Seal { cipher: "ROT13".to_owned(), ..seal };
        assert!(matches!(changed.open(key), Err(SealError::Format { name: "cipher", .. })));
        assert!(matches!(Key::parse("12é4"), Err(SealError::NoKey { .. })));
        assert!(matches!(Key::parse(&key.text()[2..]), Err(SealError::NoKey { .. })));
    }
}
