import { fileURLToPath } from 'node:url';
import { describe, expect, it } from 'vitest';
import { readSources } from './imports.ts';
import { checkWords, textsOf } from './words.ts';

describe('the words of pages', () => {
  const sources = readSources(fileURLToPath(new URL('..', import.meta.url)));

  it('are those of docs/conventions.md', () => {
    expect(checkWords(sources)).toEqual([]);
  });
  it('are found in the sources', () => {
    const all = [...sources].flatMap(([, source]) => textsOf(source));
    expect(all.length).toBeGreaterThan(600);
    expect(all.map(({ text }) => text)).toEqual(expect.arrayContaining(['Follow the instruction', 'The episode is over']));
  });
});

describe('the check of words', () => {
  const faults = (source: string) => checkWords(new Map([['pages/a.ts', source]]));

  it('reads texts and templates, and no code, comment or import', () => {
    expect(textsOf(`import { told } from './What it knew.ts'; // What it knew
/* He told
   us so */
make('p', { class: 'told' }, \`Step \${ told('x y') } of \${n}\`, 'What it knew');`))
      .toEqual([{ line: 4, text: 'Step … of …' }, { line: 4, text: 'What it knew' }]);
  });
  it('names file, line, text and the better word', () => {
    expect(faults("\nmake('h3', {}, 'Told')")).toEqual(['pages/a.ts:2: "Told": write observation, feedback']);
    expect(faults("labelled('with', 'Beside', select)")).toHaveLength(1);
    expect(faults("new Option('Colour', 'colour')")).toHaveLength(1);
    expect(faults("make('p', {}, 'Each walk beside its path.')")).toHaveLength(1);
  });
  it('leaves other uses alone', () => {
    expect(faults("make('span', { class: 'told thing' }, 'Walk the path to its end.', 'No text beside the action.')")).toEqual([]);
  });
});
