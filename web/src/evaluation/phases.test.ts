import { describe, expect, it } from 'vitest';
import { benchmarkOf, commandsOf, endOf, givesAll, inOrder, leakageOf, limitsOf, type Phase, primaryName, showingOf } from './phases.ts';

const secret: Phase = {
  phase: 'test', title: 'Test', split: 'test', task: 'r2r', task_title: 'R2R', scorer: 'enfilade', episodes: 4173, goals_secret: true,
  scores: 'after-end', primary: 'spl',
  columns: [{ name: 'spl', short: 'SPL', title: 'Success weighted by path length', unit: 'share', better: 'higher' }],
  ends: '2027-03-31T23:59:59Z', ended: false, per_day: 5, per_team: 20, step: 0.01, teams: 3,
  leakage: { most_bits: 180, goal_bits: 6600, gives_all: false, phases: ['test'] },
};

describe('phases', () => {
  it('begin with val unseen, and else stay as their organisers order them', () => {
    const named = (phase: string, split: string): Phase => ({ ...secret, phase, split });
    const list = [named('test', 'test'), named('seen', 'val_seen'), named('unseen', 'val_unseen'), named('house', 'val_unseen_house')];
    expect(inOrder(list).map(({ phase }) => phase)).toEqual(['unseen', 'house', 'test', 'seen']);
    expect(list[0]!.phase).toBe('test'); // the list itself stays
  });

  it('have the commands that make a submission', () => {
    expect(commandsOf({ ...secret, split: 'val_unseen', phase: 'ours' }, 'https://vln.example.org')).toBe(
      'enfilade run --data DATA --split val_unseen --agent random -o results.json\n'
      + 'ENFILADE_TOKEN=TOKEN enfilade submit results.json --server https://vln.example.org --phase ours --method "My method"');
    expect(commandsOf({ ...secret, task: 'r2r-ce' }, '')).toContain('run --data DATA --task r2r-ce --split test');
  });
});

describe('a phase in words', () => {
  it('says what it gives away', () => {
    expect(leakageOf(secret)).toBe('This phase can give away at most 180 bits of its goals, which have 6,600 bits.');
    const seen = { ...secret, leakage: { ...secret.leakage!, used_bits: 12, phases: ['test', 'final'] } };
    expect(leakageOf(seen)).toBe(
      'The phases test, final share goals, and together can give away at most 180 bits of this phase\'s goals, which have 6,600 bits; 12 are used.');
    expect(leakageOf({ ...secret, leakage: { ...secret.leakage!, most_bits: null } })).toContain('no limit');
    const { leakage, ...open } = secret;
    expect(leakage).toBeDefined();
    expect(leakageOf(open)).toBe('');
  });

  it('says when its limits give all goals away', () => {
    expect(givesAll(secret)).toBe(false);
    // 179.5 of 179.1 bits: equal once they are rounded.
    const small = { ...secret, leakage: { ...secret.leakage!, goal_bits: 180, gives_all: true } };
    expect(givesAll(small)).toBe(true);
    expect(leakageOf(small)).toContain('So the goals may not stay secret.');
    const { leakage, ...open } = secret;
    expect(leakage).toBeDefined();
    expect(givesAll(open)).toBe(false);
  });

  it('says when it ends and what it takes', () => {
    expect(endOf(secret)).toBe('The phase ends on 2027-03-31 23:59 UTC.');
    expect(endOf({ ...secret, ended: true })).toBe('The phase ended on 2027-03-31 23:59 UTC.');
    expect(endOf({ ...secret, ends: null })).toBe('');
    expect(limitsOf(secret)).toBe('5 a day, 20 in all');
    expect(limitsOf({ ...secret, per_team: null })).toBe('5 a day');
  });

  it('says which benchmark it is of, and what ranks', () => {
    expect(benchmarkOf(secret)).toBe('R2R');
    expect(primaryName(secret)).toBe('SPL');
    const dialogues: Phase = {
      ...secret, task: 'cvdn', task_title: 'CVDN', scorer: 'hamt', primary: 'gp', scores: 'ladder',
      columns: [{ name: 'gp', short: 'GP', title: 'Goal progress', unit: 'm', better: 'higher' }],
    };
    expect(benchmarkOf(dialogues)).toBe('CVDN, scored as hamt');
    expect(primaryName(dialogues)).toBe('GP');
    expect(showingOf(dialogues)).toContain('sees its GP only when that is at least 0.1 m better');
  });

  it('says what is shown', () => {
    expect(showingOf(secret)).toContain('rounded to 1 % and 0.1 m');
    expect(showingOf({ ...secret, scores: 'ladder' })).toContain('at least 1 % better');
    expect(showingOf({ ...secret, scores: 'hidden' })).toContain('only the organisers');
    expect(showingOf({ ...secret, ended: true })).toContain('each team has one row');
    expect(showingOf({ ...secret, goals_secret: false, scores: 'public' })).toBe('');
  });
});
