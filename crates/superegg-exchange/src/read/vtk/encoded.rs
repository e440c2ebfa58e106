//! Binary data of VTK's XML files: a header of lengths, then bytes, raw or in base64, in one piece
//! or in blocks that are compressed by zlib.

use std::borrow::Cow;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use flate2::{Decompress, FlushDecompress, Status};

use super::super::scalars::ByteOrder;

/// Some writers leave out the padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// How the binary data of a file are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Encoding {
    /// The size of a length in bytes: 4 or 8.
    pub(super) length_size: usize,
    /// The order of the bytes of lengths and numbers.
    pub(super) order: ByteOrder,
    /// The data are in blocks that zlib compressed.
    pub(super) is_compressed: bool,
}

/// The bytes of a file from the start of an array on.
#[derive(Clone, Copy, Debug)]
pub(super) enum Encoded<'a> {
    /// The bytes themselves.
    Raw(&'a [u8]),
    /// Base64 without blanks.
    Base64(&'a [u8]),
}

impl<'a> Encoded<'a> {
    /// The first `count` bytes and what lies after them. In base64 what lies after them begins
    /// with a new group of four.
    fn split(self, count: usize) -> Result<(Cow<'a, [u8]>, Self), String> {
        let ends_early = || format!("the data end early: {count} bytes are expected");
        match self {
            Self::Raw(bytes) => {
                let (first, rest) = bytes.split_at_checked(count).ok_or_else(ends_early)?;
                Ok((Cow::Borrowed(first), Self::Raw(rest)))
            }
            Self::Base64(text) => {
                let letters = count.div_ceil(3).checked_mul(4).ok_or_else(ends_early)?;
                let (first, rest) = text.split_at(letters.min(text.len()));
                let mut bytes = BASE64.decode(first).map_err(|error| format!("wrong base64: {error}"))?;
                if bytes.len() < count {
                    return Err(ends_early());
                }
                bytes.truncate(count);
                Ok((Cow::Owned(bytes), Self::Base64(rest)))
            }
        }
    }
}

impl Encoding {
    /// The data of an array that must have `expected` bytes, which the caller has checked against
    /// a limit.
    ///
    /// # Errors
    /// The data end early, are damaged, or have another length.
    pub(super) fn decode<'a>(&self, data: Encoded<'a>, expected: usize) -> Result<Cow<'a, [u8]>, String> {
        if self.is_compressed {
            self.inflate(data, expected).map(Cow::Owned)
        } else {
            self.plain(data, expected)
        }
    }

    /// Lengths of a header.
    fn lengths(&self, bytes: &[u8]) -> Vec<u64> {
        let number = |chunk: &[u8]| {
            let mut wide = [0; 8];
            match self.order {
                ByteOrder::Little => wide[..chunk.len()].copy_from_slice(chunk),
                ByteOrder::Big => wide[8 - chunk.len()..].copy_from_slice(chunk),
            }
            match self.order {
                ByteOrder::Little => u64::from_le_bytes(wide),
                ByteOrder::Big => u64::from_be_bytes(wide),
            }
        };
        bytes.chunks_exact(self.length_size).map(number).collect()
    }

    fn plain<'a>(&self, data: Encoded<'a>, expected: usize) -> Result<Cow<'a, [u8]>, String> {
        let (header, rest) = data.split(self.length_size)?;
        let length = self.lengths(&header)[0];
        if length != expected as u64 {
            return Err(format!("the data have {length} bytes where {expected} are expected"));
        }
        match data {
            Encoded::Raw(_) => Ok(rest.split(expected)?.0),
            Encoded::Base64(text) => {
                // Header and data are one text; some writers make two, the first one padded.
                let group = &text[..text.len().min(self.length_size.div_ceil(3) * 4)];
                if group.ends_with(b"=")
                    && BASE64.decode(group).is_ok_and(|bytes| bytes.len() == self.length_size)
                {
                    return Ok(rest.split(expected)?.0);
                }
                let whole = self.length_size.checked_add(expected).ok_or("the length is too large")?;
                let (bytes, _) = data.split(whole)?;
                let mut bytes = bytes.into_owned();
                bytes.drain(..self.length_size);
                Ok(Cow::Owned(bytes))
            }
        }
    }

    /// Header: number of blocks, their size, the size of the last one if it is shorter, and the
    /// compressed size of each.
    fn inflate(&self, data: Encoded<'_>, expected: usize) -> Result<Vec<u8>, String> {
        let (first, _) = data.split(self.length_size)?;
        let blocks = usize::try_from(self.lengths(&first)[0]).map_err(|_| "too many blocks")?;
        let header_size = blocks.checked_add(3).and_then(|count| count.checked_mul(self.length_size));
        let (header, rest) = data.split(header_size.ok_or("too many blocks")?)?;
        let header = self.lengths(&header);
        let (block, last, sizes) = (header[1], header[2], &header[3..]);
        let sum = match (blocks as u64).checked_sub(u64::from(last != 0)) {
            None => Some(0),
            Some(full) => full.checked_mul(block).and_then(|sum| sum.checked_add(last)),
        };
        if sum != Some(expected as u64) && !(blocks == 0 && expected == 0) {
            return Err(format!("the blocks have other than the {expected} bytes that are expected"));
        }
        let compressed =
            sizes.iter().try_fold(0usize, |sum, size| sum.checked_add(usize::try_from(*size).ok()?));
        let (compressed, _) = rest.split(compressed.ok_or("the blocks are too large")?)?;
        let mut inflated = vec![0; expected];
        let mut unfilled = &mut inflated[..];
        let mut unread = &compressed[..];
        for &size in sizes {
            let (input, after) = unread.split_at(size as usize);
            let length = unfilled.len().min(usize::try_from(block).unwrap_or(usize::MAX));
            let (output, left) = std::mem::take(&mut unfilled).split_at_mut(length);
            inflate_block(input, output)?;
            (unread, unfilled) = (after, left);
        }
        Ok(inflated)
    }
}

/// Fills `output` with the data of one block.
fn inflate_block(input: &[u8], output: &mut [u8]) -> Result<(), String> {
    let mut inflater = Decompress::new(true);
    let status = inflater.decompress(input, output, FlushDecompress::Finish);
    match status {
        Ok(Status::StreamEnd) if inflater.total_out() == output.len() as u64 => Ok(()),
        Ok(_) => Err("a compressed block has another length than its header says".to_owned()),
        Err(error) => Err(format!("a compressed block is damaged: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LITTLE: Encoding = Encoding { length_size: 4, order: ByteOrder::Little, is_compressed: false };

    #[test]
    fn a_header_of_its_own_text_is_read_too() {
        for text in ["AwAAAAECAw==", "AwAAAA==AQID", "AwAAAAECAw"] {
            assert_eq!(LITTLE.decode(Encoded::Base64(text.as_bytes()), 3).unwrap()[..], [1, 2, 3], "{text}");
        }
        assert_eq!(LITTLE.decode(Encoded::Base64(b"AQAAAAc="), 1).unwrap()[..], [7]);
        assert_eq!(LITTLE.decode(Encoded::Base64(b"AQAAAA==Bw=="), 1).unwrap()[..], [7]);
        assert_eq!(LITTLE.decode(Encoded::Base64(b"AAAAAA=="), 0).unwrap()[..], *b"");
    }

    #[test]
    fn lengths_that_lie_are_errors_before_memory_is_reserved() {
        let wide = Encoding { length_size: 8, order: ByteOrder::Big, is_compressed: true };
        for blocks in [1u64, u64::MAX, u64::MAX / 8, 1 << 40] {
            for block in [0u64, 1, u64::MAX] {
                let header = [blocks, block, u64::MAX, u64::MAX].map(u64::to_be_bytes).concat();
                assert!(wide.decode(Encoded::Raw(&header), 8).is_err());
                assert!(LITTLE.decode(Encoded::Raw(&header), 8).is_err());
            }
        }
        assert!(LITTLE.decode(Encoded::Base64(b"\xff\xff"), 3).is_err());
        assert!(LITTLE.decode(Encoded::Raw(b""), 0).is_err());
    }
}
