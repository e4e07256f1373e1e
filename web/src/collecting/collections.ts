/** Collections as organisers and reviewers see them. Shapes: /api/v1/openapi.json. */
import type { Direction } from '../geometry/geometry.ts';

/** An entry of a walk's trajectory. */
export interface Entry extends Direction {
  readonly viewpoint: string;
  /** Since the walk began. */
  readonly seconds: number;
}

/** What workers of a collection do. */
export type Kind = 'write' | 'walk' | 'describe' | 'find' | 'guide' | 'dialogue';

/** Where an object is in a panorama: corners of a box as heading and elevation, radians. */
export type Outline = readonly (readonly [number, number])[];

/** What is to be described or found. */
export interface Target {
  /** As people call it. */
  readonly name: string;
  /** By viewpoints that see it, the largest first. */
  readonly outlines: Readonly<Record<string, readonly Outline[]>>;
}

/** A word, and when it was said: seconds since the work began. */
export interface TimedWord {
  readonly word: string;
  readonly start: number;
  readonly end: number;
}

export type Role = 'navigator' | 'oracle';

/** What was said in a dialogue, or a step. */
export interface Turn extends Direction {
  /** Rising numbers; of reviewed work absent. */
  readonly turn?: number;
  readonly role: Role;
  /** Absent of a step. */
  readonly text?: string;
  /** Where the navigator stands. */
  readonly viewpoint: string;
}

/** A task that a preview shows: without a number, without a lease. */
export interface Example {
  readonly kind: Kind;
  readonly scan: string;
  /** At the start, radians. */
  readonly heading: number;
  /** To be described. */
  readonly path?: readonly string[];
  /** To be followed, from `start`. */
  readonly instruction?: string;
  readonly start?: string;
  /** To be described; of an oracle, what the navigator looks for. */
  readonly object?: Target;
  /** In a dialogue: what the navigator looks for. */
  readonly target?: string;
  /** It is not kept for the collection. */
  readonly practice?: boolean;
}

export interface Collection {
  /** Its name, a part of addresses. */
  readonly collection: string;
  readonly title: string;
  readonly kind: Kind;
  /** Of guides, as RxR writes it: "en-US". */
  readonly language?: string;
  readonly state: 'open' | 'closed' | 'archived';
  readonly platform: { readonly kind: 'self' | 'mturk' | 'prolific' };
  /** Markdown. */
  readonly consent: string;
  readonly instructions: string;
  readonly synthetic: boolean;
  /** As workers read it before they agree. */
  readonly pay?: string;
  /** Minutes per task, as workers read it. */
  readonly minutes?: number;
  readonly per_item?: number;
  readonly lease_minutes?: number;
  readonly tasks_per_visit?: number;
  readonly check_every?: number;
  readonly seed?: number;
  readonly splits?: readonly { readonly split: string; readonly items: number; readonly goals_hidden: boolean }[];
  readonly progress?: Progress;
  /** Path and query of the page for workers. Organisers only. */
  readonly link?: string;
}

export interface Progress {
  readonly items: number;
  readonly places: number;
  readonly leased: number;
  readonly submitted: number;
  readonly accepted: number;
  readonly rejected: number;
  readonly complete: number;
  readonly workers: number;
  /** Median of a task, by the server's clock; 0: none is submitted. */
  readonly minutes: number;
  /** On which something was done, the last 60, by rising date. */
  readonly days: readonly Day[];
}

/** What was done on a day of UTC. */
export interface Day {
  /** "2026-11-30" */
  readonly day: string;
  readonly submitted: number;
  /** Verdicts of reviewers. */
  readonly reviewed: number;
}

/** How far workers of the same item agree. */
export interface Agreement {
  /** F1 of the tokens of two texts; or 1 if both workers or neither reached the goal, else 0. */
  readonly measure: 'token-f1' | 'same-outcome';
  /** That two workers or more have done, and the pairs of workers. */
  readonly items: number;
  readonly pairs: number;
  readonly mean: number | null;
  /** The mean for texts of two different paths, to compare with. */
  readonly others?: number | null;
  readonly success?: number | null;
  /** Mean difference between two workers' distances from the goal. */
  readonly metres?: number | null;
  readonly least: readonly { readonly path_id: number; readonly number: number; readonly tasks: number; readonly value: number }[];
}

/** A screening or an attention check, whose right answers are known. */
export interface QuestionResult {
  readonly question: number;
  readonly stage: 'screening' | 'check';
  readonly text: string;
  readonly answered: number;
  readonly right: number;
  /** For organisers. */
  readonly choices?: readonly { readonly choice: string; readonly chosen: number; readonly right: boolean }[];
}

/** What a file has, and what it leaves out. */
export interface ExportReport {
  readonly exported: { readonly items: number; readonly paths: number; readonly tasks: number };
  /** In words. */
  readonly summary: string;
}

/** Submitted work of a worker, or of a path, in numbers. */
export interface WorkSummary {
  readonly worker?: number;
  readonly path_id?: number;
  readonly submitted: number;
  readonly accepted: number;
  readonly rejected: number;
  readonly flagged: number;
  readonly mean_seconds: number;
  readonly checks?: number;
  readonly checks_failed?: number;
}

export interface Change {
  readonly when: string;
  readonly who: string;
  readonly what: 'edited' | 'accepted' | 'rejected';
  /** What stood there before an edit. */
  readonly before?: string;
  readonly reason?: string;
}

/** What a worker submitted. */
export interface Work {
  readonly task: number;
  readonly kind: Kind;
  readonly state: 'submitted' | 'accepted' | 'rejected';
  readonly worker: number;
  readonly split: string;
  readonly path_id: number;
  readonly scan: string;
  readonly heading: number;
  readonly path?: readonly string[];
  readonly instruction?: string;
  readonly start?: string;
  readonly leased?: string;
  readonly submitted: string;
  /** By the server's clock, breaks included. */
  readonly seconds?: number;
  /** As the page measured them. */
  readonly page_seconds: number;
  readonly flags?: readonly string[];
  readonly bonus?: boolean;
  readonly steps?: readonly Entry[];
  readonly object?: Target;
  /** Of a description: how many looked for the object by it. */
  readonly verified?: { readonly walked: number; readonly found: number };
  /** Where the worker pointed, from the end of the walk; and the object there. */
  readonly point?: Direction;
  readonly pointed_at?: number | null;
  readonly words?: readonly TimedWord[];
  readonly spoken?: boolean;
  readonly role?: Role;
  readonly dialogue?: number;
  readonly turns?: readonly Turn[];
  readonly reason?: string;
  readonly history?: readonly Change[];
}
