/** Checks the words that pages say: those of docs/conventions.md in place of others. */
import type { Sources } from './imports.ts';

/** What no page says, and what it says instead. */
const instead: readonly (readonly [RegExp, string])[] = [
  [/\b(told|knew)\b/i, 'observation, feedback'],
  [/^beside$/i, 'compare with'],
  [/\bcolour$|^colour\b/i, 'RGB'],
  [/\bthings?\b/i, 'object'],
  [/\bsentences?\b/i, 'instruction'],
  [/\byour look\b/i, 'where you look'],
  [/\ball that is open\b/i, 'every open task'],
  [/\bby a link of (your|its) own\b/i, 'with another link'],
  [/\b(the|an) agent('s)? walk/i, 'trajectory'],
  [/\b(each|\d+|no|own|another) walks?\b/i, 'trajectory'],
  [/\bwalk it yourself\b|\bwalk as (they|a model|a language model)\b/i, 'play'],
  [/\bhand(ed)? in\b/i, 'submit'],
  [/\bthat (?:is none|there is\snot)\b/i, 'unknown, missing'],
];

/** A text of a source without the code in it: "of ${count}" is "of …". */
interface Said { readonly line: number; readonly text: string }

const withoutComments = (source: string): string =>
  source.replaceAll(/\/\*[^]*?\*\//g, (comment) => comment.replaceAll(/[^\n]/g, '')).replaceAll(/(^|[\s;{})])\/\/ .*$/gm, '$1');

/** Texts that people may read: those of more than one word, or with a capital. No names of classes, addresses or imports. */
export function textsOf(source: string): Said[] {
  const found: Said[] = [];
  withoutComments(source).split('\n').forEach((line, k) => {
    if (/^\s*(import|export) .* from /.test(line)) return;
    for (const [, single, template] of line.matchAll(/'((?:[^'\\]|\\.)*)'|`((?:[^`\\]|\\.)*)`/g)) {
      const text = (single ?? template ?? '').replaceAll(/\$\{(?:[^{}]|\{[^{}]*\})*\}/g, '…').trim();
      const isRead = /^\p{Lu}/u.test(text) || /\p{L}{2,} \p{L}{2,}/u.test(text);
      const isName = /^[a-z-]+( [a-z-]+)*$/.test(text) && new RegExp(`class: '${text}'`).test(line);
      if (isRead && !isName && !/^[./]/.test(text)) found.push({ line: k + 1, text });
    }
  });
  return found;
}

/** Each text with a word that another stands for, as a line. The page of styles, for developers, is left out. */
export function checkWords(sources: Sources): string[] {
  return [...sources].filter(([file]) => !file.endsWith('.test.ts') && !file.startsWith('testing/') && file !== 'pages/styles.ts')
    .flatMap(([file, source]) => textsOf(source).flatMap(({ line, text }) =>
      instead.filter(([word]) => word.test(text)).map(([, better]) => `${file}:${line}: ${JSON.stringify(text)}: write ${better}`)));
}
