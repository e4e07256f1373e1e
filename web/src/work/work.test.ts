import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { parseQuestions, writeQuestions } from '../collecting/questions.ts';
import { degrees } from '../geometry/geometry.ts';
import { ServerError } from '../server/api.ts';
import { Drafts, type DraftState } from './drafts.ts';
import { type Behaviour, hintsFor, tooShort, wordsIn } from './hints.ts';
import { Looks } from './looks.ts';
import { Recorder } from './recorder.ts';
import { openStorage } from './storage.ts';

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
  it('are no wall but for what the server refuses', () => {
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

describe('questions', () => {
  const typed = 'Are you at least 18?\n* Yes\nNo\n\n  Choose a colour. \n*Red\n* Blue\nGreen\n';
  const parsed = [
    { question: 'Are you at least 18?', choices: ['Yes', 'No'], accept: ['Yes'] },
    { question: 'Choose a colour.', choices: ['Red', 'Blue', 'Green'], accept: ['Red', 'Blue'] },
  ];
  it('are typed in blocks, and written back', () => {
    expect(parseQuestions(typed)).toEqual(parsed);
    expect(parseQuestions(writeQuestions(parsed))).toEqual(parsed);
    expect(parseQuestions(' \n\n ')).toEqual([]);
  });
  it('are refused by their name', () => {
    expect(() => parseQuestions('Why?\n* Because')).toThrow('"Why?": write two choices');
    expect(() => parseQuestions('Why?\nThis\nThat')).toThrow('put a *');
  });
});

describe('storage', () => {
  it('is the page\'s memory where the browser gives none', () => {
    const storage = openStorage(() => { throw new DOMException('denied', 'SecurityError'); });
    expect(storage.lasting).toBe(false);
    storage.setItem('a', '1');
    expect(storage.getItem('a')).toBe('1');
    storage.removeItem('a');
    expect(storage.getItem('a')).toBeNull();
  });
  it('is the browser\'s where there is one', () => {
    const kept = new Map<string, string>();
    const browser = { getItem: (key: string) => kept.get(key) ?? null, setItem: (key: string, value: string) => void kept.set(key, value), removeItem: (key: string) => void kept.delete(key) };
    const storage = openStorage(() => browser as Storage);
    storage.setItem('a', '1');
    expect(storage.lasting).toBe(true);
    expect([...kept]).toEqual([['a', '1']]);
  });
});

describe('looking around', () => {
  it('is three twelfths of a turn at the same viewpoint', () => {
    const looks = new Looks();
    const see = (viewpoint: number, heading: number) => looks.see(viewpoint, { heading: degrees(heading), elevation: 0 });
    see(1, 10);
    see(1, 40);
    see(2, 70);
    expect(looks.around(1)).toBe(false);
    see(1, 359.9);
    expect(looks.around(1)).toBe(true);
    expect(looks.around(2)).toBe(false);
  });
});

describe('a recorded walk', () => {
  const walk = () => {
    let clock = 100;
    const recorder = new Recorder('a', { heading: 0, elevation: 0 }, [], () => clock);
    return {
      recorder,
      see: (viewpoint: string, heading: number, seconds: number) => {
        clock = 100 + seconds;
        recorder.see(viewpoint, { heading: degrees(heading), elevation: 0 });
      },
    };
  };
  const short = (recorder: Recorder) =>
    recorder.entries().map(({ viewpoint, heading, seconds }) => [viewpoint, Math.round((heading * 180) / Math.PI), seconds]);

  it('has the look before each step, the step, and the last look', () => {
    const { recorder, see } = walk();
    see('a', 5, 1);
    see('a', 8, 2);
    see('b', 8, 3);
    see('b', 8, 4); // nothing new
    see('b', 350, 5);
    expect(short(recorder)).toEqual([['a', 0, 0], ['a', 8, 2], ['b', 8, 3], ['b', 350, 5]]);
    expect(recorder.steps).toBe(1);
  });
  it('leaves no gap of more than half a view in a slow turn', () => {
    const { recorder, see } = walk();
    for (let k = 1; k <= 90; ++k) see('a', k, k);
    const headings = recorder.entries().map(({ heading }) => (heading * 180) / Math.PI);
    expect(headings.at(-1)).toBeCloseTo(90);
    for (const [k, heading] of headings.slice(1).entries()) expect(heading - headings[k]!).toBeLessThanOrEqual(16.001);
  });
  it('measures turns the shorter way round', () => {
    const { recorder, see } = walk();
    see('a', 355, 1);
    see('a', 350, 2);
    expect(short(recorder)).toEqual([['a', 0, 0], ['a', 350, 2]]);
  });
  it('goes on after a reload', () => {
    const before = [{ viewpoint: 'a', heading: 0, elevation: 0, seconds: 0 }, { viewpoint: 'b', heading: 0, elevation: 0, seconds: 9 }];
    let clock = 500;
    const recorder = new Recorder('b', { heading: 0, elevation: 0 }, before, () => clock);
    clock = 503;
    recorder.see('c', { heading: 0, elevation: 0 });
    expect(short(recorder)).toEqual([['a', 0, 0], ['b', 0, 9], ['c', 0, 12]]);
    expect(recorder.steps).toBe(2);
  });
  it('ends where one looked last, once', () => {
    const { recorder, see } = walk();
    see('a', 4, 1);
    expect(recorder.entries()).toHaveLength(2);
    expect(recorder.entries()).toHaveLength(2);
    see('a', 0, 2);
    expect(short(recorder).at(-1)).toEqual(['a', 0, 2]);
  });
  it('keeps steps only, once there are a thousand looks', () => {
    const { recorder, see } = walk();
    for (let k = 1; k < 3000; ++k) see('a', (k * 90) % 360, k);
    see('b', 0, 3000);
    expect(recorder.entries().length).toBeLessThanOrEqual(1002);
    expect(recorder.steps).toBe(1);
  });
});

describe('a draft', () => {
  const kept = new Map<string, string>();
  const storage = {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => void kept.set(key, value),
    removeItem: (key: string) => void kept.delete(key),
  };
  interface Text { readonly text: string }
  const sent: string[] = [];
  const told: DraftState[] = [];
  let reachable = true;
  const open = () => {
    const drafts = new Drafts<Text>('7', storage, async ({ text }) => {
      if (!reachable) throw new TypeError('no network');
      sent.push(text);
    });
    drafts.onState((state) => told.push(state));
    return drafts;
  };

  beforeEach(() => {
    vi.useFakeTimers();
    for (const list of [sent, told]) list.length = 0;
    kept.clear();
    reachable = true;
  });
  afterEach(() => {
    vi.useRealTimers();
  });

  it('is here at once and at the server after a pause', async () => {
    const drafts = open();
    expect(drafts.begin(undefined)).toBeUndefined();
    drafts.change({ text: 'Go' });
    drafts.change({ text: 'Go left' });
    const again = open(); // as after a reload
    expect(again.begin(undefined)?.text).toBe('Go left');
    again.dispose();
    await vi.advanceTimersByTimeAsync(1199);
    expect(sent).toEqual([]);
    await vi.advanceTimersByTimeAsync(1);
    expect(sent).toEqual(['Go left']);
    expect(told).toEqual(['saving', 'saving', 'saved']);
    drafts.forget();
    expect(kept.size).toBe(0);
  });
  it('is sent at once when the page is about to go', async () => {
    const drafts = open();
    await drafts.save();
    expect(sent).toEqual([]); // there is nothing
    drafts.change({ text: 'Go' });
    await drafts.save();
    expect(sent).toEqual(['Go']);
    expect(vi.getTimerCount()).toBe(0);
  });
  it('gives way to a newer one of another browser', async () => {
    open().change({ text: 'old' });
    await vi.advanceTimersByTimeAsync(1200);
    expect(open().begin({ text: 'newer, from elsewhere' })?.text).toBe('newer, from elsewhere');
  });
  it('is sent again when the server was away', async () => {
    const drafts = open();
    reachable = false;
    drafts.change({ text: 'Go' });
    await vi.advanceTimersByTimeAsync(1200);
    expect(told.at(-1)).toBe('here');
    reachable = true;
    await vi.advanceTimersByTimeAsync(5000);
    expect(sent).toEqual(['Go']);
    expect(told.at(-1)).toBe('saved');
    expect(vi.getTimerCount()).toBe(0);
  });
  it('is sent as a sign of life, now and then', async () => {
    const drafts = open();
    for (let second = 0; second < 60; ++second) {
      drafts.stir(() => ({ text: `at ${second}` }));
      await vi.advanceTimersByTimeAsync(1000);
    }
    expect(sent).toEqual(['at 20', 'at 42']); // 20 s after the one before, and the pause
    expect(told).toEqual(['saved', 'saved']);
  });
  it('is not sent again to a server that refuses it', async () => {
    const drafts = new Drafts<Text>('7', storage, async () => {
      throw new ServerError(409, 'lease-expired', 'it lapsed');
    });
    drafts.onState((state) => told.push(state));
    drafts.change({ text: 'Go' });
    await vi.advanceTimersByTimeAsync(60_000);
    expect(told).toEqual(['saving', 'lost']);
    expect(open().begin(undefined)?.text).toBe('Go'); // and still here
  });
  it('outlives rubbish in the storage, and a storage that is full', () => {
    kept.set('enfilade-draft/7', '{"draft": 7');
    expect(open().begin({ text: 'at server' })?.text).toBe('at server');
    const full = openStorage(() => ({
      ...storage, setItem: (_: string, value: string) => { if (value !== '') throw new Error('quota'); },
    }) as unknown as Storage);
    expect(full.lasting).toBe(true);
    const drafts = new Drafts<Text>('7', full, async () => {});
    drafts.change({ text: 'Go' });
    drafts.dispose();
  });
});
