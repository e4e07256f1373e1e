import { describe, expect, it } from 'vitest';
import type { Collection } from './collections.ts';
import { instructionsText } from './default_texts.ts';
import { instructionsAfter, summaryOf } from './new_collection.ts';

describe('instructions after a change of the type', () => {
  it('are the other draft, if nobody wrote them', () => {
    expect(instructionsAfter(instructionsText.write, 'walk')).toBe(instructionsText.walk);
    expect(instructionsAfter(instructionsText.walk, 'dialogue')).toBe(instructionsText.dialogue);
  });
  it('stay, if an organiser wrote them', () => {
    const own = `${instructionsText.write}\nAnd greet the robot.`;
    expect(instructionsAfter(own, 'walk')).toBe(own);
    expect(instructionsAfter('', 'walk')).toBe('');
  });
});

describe('what a collection would have', () => {
  const of = (kind: Collection['kind'], more: object) =>
    summaryOf({ collection: { kind } as Collection, example: { kind, scan: 's', heading: 0 }, ...more });
  it.each([
    ['write', { items: 8, paths: 8 }, '8 paths.'],
    ['write', { items: 1, paths: 1 }, '1 path.'],
    ['walk', { items: 1200, paths: 400 }, '1,200 instructions on 400 paths.'],
    ['describe', { items: 4, paths: 3, objects: [{ name: 'bed', items: 3 }, { name: 'coat', items: 1 }] }, '4 objects on 3 paths: 3 × bed, coat.'],
    ['dialogue', { items: 1, paths: 1, objects: [{ name: 'bed', items: 1 }] }, '1 goal on 1 path: bed.'],
  ] as const)('%s', (kind, more, words) => {
    expect(of(kind, more)).toBe(words);
  });
});
