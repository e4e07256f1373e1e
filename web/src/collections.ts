/** Collections as organisers and reviewers see them. Shapes: /api/v1/openapi.json. */
import type { Direction } from './geometry.ts';

/** An entry of a walk's trajectory. */
export interface Entry extends Direction {
  readonly viewpoint: string;
  /** Since the walk began. */
  readonly seconds: number;
}

export interface Collection {
  /** Its name, a part of addresses. */
  readonly collection: string;
  readonly title: string;
  readonly kind: 'write' | 'walk';
  readonly state: 'open' | 'closed';
  readonly platform: { readonly kind: 'self' | 'mturk' | 'prolific' };
  /** Markdown. */
  readonly consent: string;
  readonly instructions: string;
  readonly synthetic: boolean;
  readonly per_item?: number;
  readonly lease_minutes?: number;
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
}

export interface Change {
  readonly when: string;
  readonly who: string;
  readonly what: 'edited' | 'accepted' | 'rejected';
  /** What stood there before an edit. */
  readonly before?: string;
  readonly reason?: string;
}

/** What a worker handed in. */
export interface Work {
  readonly task: number;
  readonly kind: 'write' | 'walk';
  readonly state: 'submitted' | 'accepted' | 'rejected';
  readonly worker: number;
  readonly split: string;
  readonly path_id: number;
  readonly scan: string;
  readonly heading: number;
  readonly path?: readonly string[];
  readonly instruction?: string;
  readonly start?: string;
  readonly submitted: string;
  readonly seconds?: number;
  readonly flags?: readonly string[];
  readonly bonus?: boolean;
  readonly steps?: readonly Entry[];
  readonly reason?: string;
  readonly history?: readonly Change[];
}
