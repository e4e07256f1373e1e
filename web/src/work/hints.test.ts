import { describe, expect, it } from 'vitest';
import { type Behaviour, hintsFor, tooShort, wordsIn } from './hints.ts';

describe('hints', () => {
  const good: Behaviour = { pasted: 0, goalSeen: true };
  const codes = (text: string, behaviour: Partial<Behaviour> = {}) =>
    hintsFor(text, { ...good, ...behaviour }).map(({ code }) => code);
  const text = 'Leave the kitchen, go past the sofa and stop at the door.';

  it('are silent about directions with nothing odd', () => {
    expect(codes(text)).toEqual([]);
    expect(codes('Go up and stop there please')).toEqual([]); // six words
  });
  it('say what may be missing', () => {
    expect(codes('Go up and stop there')).toEqual(['short']);
    expect(codes(text, { pasted: 40 })).toEqual(['pasted']);
    expect(codes(text, { goalSeen: false })).toEqual(['goal-not-seen']);
  });
  it('are no wall except for what the server refuses', () => {
    expect(tooShort('')).toContain('first');
    expect(tooShort('  Go left ')).toContain('too short');
    expect(tooShort('Go up to')).toContain('too short'); // eight characters
    expect(tooShort('Go up there')).toBeUndefined();
  });
  it('count words of any script', () => {
    expect(wordsIn(' Go , left - at 2 ')).toBe(4);
    expect(wordsIn('иди прямо')).toBe(2);
    expect(wordsIn('')).toBe(0);
  });
});
