import { describe, expect, it } from 'vitest';
import { callOfKey } from './plays.ts';
import { callText, endText, type Observation, parseStep, placeText, turnText } from './runs.ts';

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
