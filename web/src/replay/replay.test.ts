import { describe, expect, it } from 'vitest';
import { callOfKey } from './plays.ts';
import { orderText, parseOrder, runColumns, sortRuns, timeText, valueText } from './columns.ts';
import { differenceText, pText, verdict } from './comparison.ts';
import {
  address, callText, endText, keyOfRun, type Measures, noResponseText, type Observation, outcomeWords, parseStep, placeText, type Run, turnText,
} from './runs.ts';

describe('a replay in words', () => {
  it('has a step in its address, whatever stands there', () => {
    expect(['#3', '3', '#0', '#99', '', '#', '#-1', '#2x', '#1e3', '#<b>', '#12345678'].map((hash) => parseStep(hash, 7)))
      .toEqual([3, 3, 1, 7, 1, 1, 1, 1, 1, 1, 1]);
  });
  it('says what was called', () => {
    expect(callText({ tool: 'go_to', argument: 'B' })).toBe('go_to B');
    expect(callText({ tool: 'stop', argument: '' })).toBe('stop');
    expect(callText(null)).toBe('no call');
  });
  it('says how it ended', () => {
    expect(endText({ ending: 'stopped', steps: 1, mistakes: 0 })).toBe('stopped after 1 step, no mistake');
    expect(endText({ ending: 'out-of-steps', steps: 30, mistakes: 1 })).toBe('ran out of steps after 30 steps, 1 mistake');
    expect(endText({ ending: 'refused', steps: 2, mistakes: 0 })).toBe('was broken off by the server after 2 steps, no mistake');
    expect(endText({ ending: 'refused', steps: 2, mistakes: 1, reason: 'no-answer: length' }))
      .toBe('was broken off by the server after 2 steps, 1 mistake; no-answer: length');
  });
  it('says what came of it, where that is known', () => {
    const end = { ending: 'stopped', steps: 5, mistakes: 0 } as const;
    const outcome = {
      kind: 'end', path: [], walk: [], viewpoints: [], length: 8, error: 1.23, success: true, success_distance: 3, spl: 0.874,
    } as const;
    expect(outcomeWords({ end, outcome })).toBe('It stopped 1.2 m from the goal: success, SPL 0.87. Success is to stop nearer than 3 m to the goal.');
    expect(outcomeWords({ end: { ...end, ending: 'out-of-steps' }, outcome: { ...outcome, error: null, success: false } }))
      .toContain('It ended where no path leads to the goal: failure, SPL 0.87.');
    expect(outcomeWords({ end, outcome: { ...outcome, kind: 'object', answer: false } }))
      .toContain('from the goal, and named another object: success');
    expect(outcomeWords({ end })).toBe('');
  });
  it('says why a response has no text', () => {
    expect(noResponseText({ flaw: 'length' })).toBe('The response was cut off at the limit of tokens.');
    expect(noResponseText({})).toBe('No text beside the action.');
    expect(noResponseText({ flaw: 'toString' })).toBe('No text beside the action.');
  });
  it('says where a place lies', () => {
    expect([0.2, -0.4, 90, -12.6, 180, -180, 179.7].map(turnText)).toEqual(
      ['ahead', 'ahead', '90° to the right', '13° to the left', 'behind', 'behind', 'behind']);
    const place = { name: 'B', turn: 30, elevation: -12, distance: 2.34, visited: false, seen_before: false };
    expect(placeText(place)).toBe('30° to the right, 12° down, 2.3 m');
    expect(placeText({ ...place, turn: 0, elevation: 0.3 })).toBe('ahead, 2.3 m');
  });
});

describe('keys of who walks', () => {
  const seen: Observation = {
    instruction: '', step: 0, heading: 0, elevation: 0, told: '',
    tools: [{ tool: 'go_to', argument: 'place', allowed: ['B', 'C'] }, { tool: 'back_to', argument: 'place', allowed: ['A', 'B'] },
      { tool: 'look', argument: 'direction', allowed: ['left', 'right', 'behind', 'up', 'down'] }, { tool: 'stop' }],
  };
  it('go to a neighbour, else back to a place', () => {
    expect(callOfKey('b', seen)).toEqual(['go_to', 'B']);
    expect(callOfKey('C', seen)).toEqual(['go_to', 'C']);
    expect(callOfKey('a', seen)).toEqual(['back_to', 'A']);
  });
  it('look around, and do nothing that is not possible', () => {
    expect(callOfKey('ArrowDown', seen)).toEqual(['look', 'down']);
    expect(['z', 'Enter', ' ', 'Tab', '1', 'AA'].map((key) => callOfKey(key, seen))).toEqual(Array(6).fill(undefined));
    expect(callOfKey('b', { ...seen, tools: [] })).toBeUndefined();
  });
  it('move in continuous space', () => {
    const free = { ...seen, tools: [{ tool: 'move', argument: 'actions', allowed: ['forward', 'left', 'right'], list: true }] };
    expect(callOfKey('ArrowUp', free)).toEqual(['move', 'forward']);
    expect(callOfKey('ArrowDown', free)).toBeUndefined();
  });
});

describe('a table of runs', () => {
  const run = (name: string, more: Partial<Run> = {}): Run =>
    ({ run: name, task: 'r2r', split: 'val_unseen', model: 'm', prompt: 'text', outcomes: true, episodes: 6, ...more });
  const measured = (one: Run, sr: number | null, more: Partial<Measures> = {}): Measures => ({
    ...one, steps: 30, mistakes: 2, unanswered: 1, prompt_tokens: 1000, answer_tokens: 50, scored: 6,
    scores: [{ name: 'spl', short: 'SPL', title: 'Success weighted by path length', unit: 'share', better: 'higher', mean: 0.25 },
      { name: 'success', short: 'SR', title: 'Success rate', unit: 'share', better: 'higher', mean: sr },
      { name: 'nav_error', short: 'NE', title: 'Navigation error', unit: 'm', better: 'lower', mean: 3.256 }], ...more });
  const [a, b, c, hidden] = [run('a'), run('b'), run('c'), run('hidden', { split: 'test', outcomes: false })];
  const all = [measured(a, 0.5), measured(b, 0.714), measured(c, null), measured(hidden, null, { scored: 0, scores: [] })];
  const byName = new Map(all.map((one) => [one.run, one]));

  it('has a column for each measure that some run has', () => {
    const names = (known: readonly Measures[], runs: readonly Run[] = [a, hidden]) => runColumns(runs, known).map(({ name }) => name);
    expect(names(all)).toEqual(['SR', 'SPL', 'NE', 'Episodes', 'Mistakes', 'Empty', 'Tokens']);
    expect(names([measured(a, 0.5, { seconds: 3, money: 0.2 })]))
      .toEqual(['SR', 'SPL', 'NE', 'Episodes', 'Mistakes', 'Empty', 'Tokens', 'Cost', 'Time']);
    expect(names([], [hidden])).toEqual(['Episodes', 'Mistakes', 'Empty', 'Tokens']);
    const progress = { name: 'gp', short: 'GP', title: 'Goal progress', unit: 'm', better: 'higher', mean: 1.5 } as const;
    expect(names([measured(a, 0.5, { scores: [progress, ...all[0]!.scores] })]))
      .toEqual(['SR', 'SPL', 'NE', 'GP', 'Episodes', 'Mistakes', 'Empty', 'Tokens']);
  });
  it('shows them in their units, and a dash for what is not known', () => {
    const text = (name: string, of: Run) => runColumns([a, hidden], all).find((one) => one.name === name)!.text(of, byName.get(of.run));
    expect(['SR', 'SPL', 'NE', 'Tokens'].map((name) => text(name, a))).toEqual(['50.0', '25.0', '3.26', '1,050']);
    expect(['SR', 'SPL', 'NE', 'Mistakes'].map((name) => text(name, hidden))).toEqual(['–', '–', '–', '2']);
    expect(text('SR', c)).toBe('–');
    expect([valueText(0, 'share'), valueText(12.345, 'count'), valueText(12345.6, 'count'), valueText(NaN, 'm')])
      .toEqual(['0.0', '12.3', '12,346', '–']);
    expect([0.44, 119, 600, 9000].map(timeText)).toEqual(['0.4 s', '119 s', '10 min', '2.5 h']);
  });
  it('is sorted by any of them, what is not known last', () => {
    const sr = runColumns([a], all).find(({ name }) => name === 'SR')!;
    const sorted = (direction: 'ascending' | 'descending') => sortRuns([c, a, hidden, b], byName, sr, direction).map(({ run: name }) => name);
    expect(sorted('descending')).toEqual(['b', 'a', 'c', 'hidden']);
    expect(sorted('ascending')).toEqual(['a', 'b', 'c', 'hidden']);
  });
  it('keeps its order in the address', () => {
    const columns = [{ name: 'SR', first: 'descending' }, { name: 'NE', first: 'ascending' }] as const;
    expect(orderText({ by: 'SR', direction: 'descending' }, 'descending')).toBe('SR');
    expect(orderText({ by: 'SR', direction: 'ascending' }, 'descending')).toBe('SR-ascending');
    expect(parseOrder('SR-ascending', columns)).toEqual({ by: 'SR', direction: 'ascending' });
    expect(parseOrder('NE', columns)).toEqual({ by: 'NE', direction: 'ascending' });
    expect(parseOrder('NE-up', columns)).toEqual({ by: 'NE', direction: 'ascending' });
    expect([null, '', 'toString', 'SR2'].map((text) => parseOrder(text, columns))).toEqual(Array(4).fill(undefined));
  });
  it('leads to pages by addresses that any name may be in', () => {
    expect(address({ run: 'a & b', episode: '1_0' }, '#3')).toBe('/replay?run=a+%26+b&episode=1_0#3');
    expect(keyOfRun({ task: 'reverie', split: 'val_seen' })).toBe('reverie/val_seen');
    expect(keyOfRun({ task: 'r2r', split: null })).toBeUndefined();
  });
});

describe('two runs compared', () => {
  it('says a difference with its sign and interval', () => {
    expect(differenceText({ unit: 'share', difference: { mean: 0.0421, low: -0.01, high: 0.091 } })).toBe('+4.2 (−1.0 to +9.1)');
    expect(differenceText({ unit: 'm', difference: { mean: -1.5, low: null, high: null } })).toBe('−1.50');
    expect(differenceText({ unit: 'share', difference: { mean: -0.0001, low: 0, high: 0 } })).toBe('0.0 (0.0 to 0.0)');
    expect([0, 0.002, 0.0456, 0.5, 1].map(pText)).toEqual(['< 0.002', '0.002', '0.046', '0.50', '1.00']);
  });
  it('says which is better, beyond chance alone', () => {
    const of = (mean: number, better: 'higher' | 'lower' | undefined, p: number) =>
      verdict({ difference: { mean, low: null, high: null }, p, ...(better && { better }) });
    expect(of(0.1, 'higher', 0.01)).toBe('second');
    expect(of(-0.1, 'higher', 0.01)).toBe('first');
    expect(of(-1, 'lower', 0.04)).toBe('second');
    expect([of(0.1, 'higher', 0.05), of(0.1, undefined, 0.01), of(0, 'higher', 0.01)]).toEqual([undefined, undefined, undefined]);
  });
});
