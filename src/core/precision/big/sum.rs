//! Sums of products of whole numbers, exactly, in words that are added up in place.

use dashu_int::{IBig, UBig, Word};

/// Bits of a word.
pub(super) const WORD: usize = Word::BITS as usize;

/// Numbers of more words are multiplied by faster means than word by word.
const LONG: usize = 48;

/// acc += |a| |b|; `acc` is long enough for the sum.
fn multiply_add(acc: &mut [Word], a: &[Word], b: &[Word]) {
    let zeros = |x: &[Word]| x.iter().take_while(|w| **w == 0).count();
    let (za, zb) = (zeros(a), zeros(b));
    let (a, b) = (&a[za..], &b[zb..]);
    for (i, &x) in a.iter().enumerate() {
        let x = u128::from(x);
        let mut carry: u128 = 0;
        let target = &mut acc[za + zb + i..];
        let (own, rest) = target.split_at_mut(b.len());
        for (t, &y) in own.iter_mut().zip(b) {
            // At most (w - 1)² + 2 (w - 1) = w² - 1 for words below w.
            let sum = x * u128::from(y) + u128::from(*t) + carry;
            *t = sum as Word;
            carry = sum >> Word::BITS;
        }
        for t in rest {
            if carry == 0 {
                break;
            }
            let sum = u128::from(*t) + carry;
            *t = sum as Word;
            carry = sum >> Word::BITS;
        }
    }
}

/// A sum of products, positive and negative ones apart.
#[derive(Debug, Default)]
pub(crate) struct Sum {
    plus: Vec<Word>,
    minus: Vec<Word>,
    shifted: Vec<Word>,
}

impl Sum {
    /// Space for products that end within so many words, however many there are.
    pub(crate) fn clear(&mut self, words: usize) {
        for part in [&mut self.plus, &mut self.minus] {
            part.clear();
            part.resize(words + 2, 0);
        }
    }

    /// Adds a b 2^place.
    pub(crate) fn add_product(&mut self, a: &IBig, b: &IBig, place: usize) {
        let ((sign, mut a), (other, b)) = (a.as_sign_words(), b.as_sign_words());
        let (words, bits) = (place / WORD, place % WORD);
        if bits > 0 {
            self.shifted.clear();
            let mut carry: u128 = 0;
            for word in a {
                carry |= u128::from(*word) << bits;
                self.shifted.push(carry as Word);
                carry >>= WORD;
            }
            self.shifted.extend((carry != 0).then_some(carry as Word));
            a = &self.shifted;
        }
        let part = if sign == other { &mut self.plus } else { &mut self.minus };
        let part = &mut part[words..];
        if a.len().min(b.len()) > LONG {
            let product = UBig::from_words(a) * UBig::from_words(b);
            multiply_add(part, &[1], product.as_words());
        } else {
            multiply_add(part, a, b);
        }
    }

    /// The sum.
    pub(crate) fn value(&self) -> IBig {
        let part = |words: &[Word]| UBig::from_words(words);
        IBig::from(part(&self.plus)) - IBig::from(part(&self.minus))
    }
}

/// How many words a number has.
pub(super) fn words(x: &IBig) -> usize {
    x.as_sign_words().1.len()
}
