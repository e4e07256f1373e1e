"""What the public packages make of some texts: subwords_truth.py FOLDER words|sentences.

Writes FOLDER/truth.json: the texts, and their token ids by `tokenizers` (vocab.txt, folded and as
written) or by `sentencepiece` (tiny unigram models; their ids as XLM-R shifts them)."""
import json
import pathlib
import random
import sys

PLAIN = [
    'Walk past the sofa, turn left and stop at the second door.',
    "Don't stop; it's the 2nd-floor bathroom (left of the stairs)!",
    'Naïve café façade — ÉCOLE, Ångström, Größe, İstanbul, ΑΒΓΣ ΌΣΟΣ.',
    'सोफे के पास से चलें और बाईं ओर मुड़ें। దయచేసి మెట్లు ఎక్కండి.',
    '从沙发旁边走过，然后左转。日本語のテキスト、한국어 문장입니다.',
    'tabs\tand\nlines\r\n  many   blanks\u00a0\u2003\u3000here ',
    'soft\u00adhyphen zero\u200bwidth\ufeff nul\x00byte \ufffd \x7f \x0b end',
    'ﬁre ½ ² № ① ㍿ Ａｂｃ ｶﾞ ﾊﾟ … “quotes” ‘single’ a\u0301 e\u0301\u0302 \U0001f600\U0001f3e0 \U0001d400',
    '$5 + 5% = <x> ^_^ `code` ~ | [SEP] [MASK] <s> </s> ##ing',
    'x' * 101 + ' ' + 'y' * 100,
    '', ' ', 'a', '▁', ' ▁ a', 'İ', 'ẞ', '\u0301', '가각힣',
]


def texts():
    """Texts by hand, and of random characters of many scripts."""
    rng = random.Random(20)
    blocks = [(0x20, 0x7e), (0xa0, 0x24f), (0x300, 0x36f), (0x370, 0x52f), (0x5d0, 0x5ea),
              (0x621, 0x64a), (0x904, 0x94d), (0xc05, 0xc39), (0xe01, 0xe3a), (0x10a0, 0x10c5),
              (0x1e00, 0x1fbc), (0x2000, 0x206f), (0x20a0, 0x20bf), (0x2100, 0x218b),
              (0x3040, 0x30ff), (0x4e00, 0x4eff), (0xac00, 0xacff), (0xf900, 0xf9ff),
              (0xff01, 0xffdc), (0x10400, 0x1044f), (0x1f600, 0x1f64f)]
    made = list(PLAIN)
    for _ in range(400):
        made.append(''.join(' ' if rng.random() < 0.15 else chr(rng.randint(*rng.choice(blocks)))
                            for _ in range(rng.randint(1, 40))))
    return made


def by_tokenizers(folder, lines):
    """Pieces: single characters, and the beginnings and ends of words, of three and four letters."""
    from tokenizers import Tokenizer, models, normalizers, pre_tokenizers
    pieces = dict.fromkeys(['[PAD]', '[UNK]', '[CLS]', '[SEP]', '[MASK]'])
    for lowercase in (True, False):
        cut = pre_tokenizers.BertPreTokenizer()
        for line in lines:
            clean = normalizers.BertNormalizer(lowercase=lowercase).normalize_str(line)
            for word, _ in cut.pre_tokenize_str(clean):
                for piece in (word[:1], word[:4], '##' + word[1:4], '##' + word[-3:], '##' + word[-1:]):
                    if len(piece) % 7 != 3:  # some are left out, so that words fall apart
                        pieces[piece] = None
    names = [p for p in pieces if p and '\n' not in p]
    (folder / 'vocab.txt').write_text('\n'.join(names) + '\n', encoding='utf-8', newline='\n')
    vocab = {name: k for k, name in enumerate(names)}
    found = {'texts': lines}
    for lowercase, key in ((True, 'folded'), (False, 'written')):
        model = Tokenizer(models.WordPiece(vocab, unk_token='[UNK]', max_input_chars_per_word=100))
        model.normalizer = normalizers.BertNormalizer(lowercase=lowercase)
        model.pre_tokenizer = pre_tokenizers.BertPreTokenizer()
        found[key] = [model.encode(line, add_special_tokens=False).ids for line in lines]
    return found


def by_sentencepiece(folder, lines):
    import sentencepiece
    words = ' '.join(lines[:5]).split()
    rng = random.Random(21)
    corpus = [' '.join(rng.choices(words, k=12)) for _ in range(500)]
    found = {'texts': lines}
    for key, settings in (('plain', {}), ('own', {'user_defined_symbols': ['sofa', 'so', '<x>']}),
                          ('bare', {'normalization_rule_name': 'identity',
                                    'add_dummy_prefix': False,
                                    'remove_extra_whitespaces': False})):
        sentencepiece.SentencePieceTrainer.train(
            sentence_iterator=iter(corpus), model_prefix=str(folder / key), model_type='unigram',
            vocab_size=300, hard_vocab_limit=False, minloglevel=2, **settings)
        model = sentencepiece.SentencePieceProcessor(model_file=str(folder / (key + '.model')))
        found[key] = [[k + 1 if k else 3 for k in model.encode(line)] for line in lines]
    return found


def main():
    folder = pathlib.Path(sys.argv[1])
    made = {'words': by_tokenizers, 'sentences': by_sentencepiece}[sys.argv[2]](folder, texts())
    (folder / 'truth.json').write_text(json.dumps(made), encoding='utf-8')


if __name__ == '__main__':
    main()
