/** Requests to the server. Shapes: /api/v1/openapi.json. */
import type { Layer, Legends, Plan, Scan } from '../scan/scan.ts';

interface Problem {
  readonly severity: 'note' | 'warning' | 'error';
  readonly where: string;
  readonly code: string;
  readonly message: string;
}

/** What a server answers that does not do what was asked. */
export class ServerError extends Error {
  readonly status: number;
  readonly code: string;
  readonly problems: readonly Problem[];

  constructor(status: number, code: string, message: string, problems: readonly Problem[] = []) {
    super(message);
    this.status = status;
    this.code = code;
    this.problems = problems;
  }
}

/** A server's API. `base` is its address, "" for the one that the page is from. */
export class Api {
  readonly base: string;

  constructor(base = '') {
    this.base = base.replace(/\/$/, '');
  }

  /** Throws ServerError, or TypeError if the server can't be reached. */
  async call<T>(path: string, init: RequestInit = {}): Promise<T> {
    const response = await fetch(`${this.base}/api/v1/${path}`, {
      ...init,
      // Tells the server that the request is a script's of its own pages: other sites can't.
      headers: { 'X-Enfilade': '1', ...init.headers },
    });
    const answer: unknown = await response.json().catch(() => undefined);
    if (response.ok) return answer as T;
    const error = (answer as { error?: { code: string; message: string; diagnostics?: Problem[] } })
      ?.error;
    throw new ServerError(
      response.status,
      error?.code ?? 'no-answer',
      error?.message ?? `the server answered with status ${response.status}`,
      error?.diagnostics,
    );
  }

  scan(scan: string): Promise<Scan> {
    return this.call(`scans/${encodeURIComponent(scan)}`);
  }

  plan(scan: string): Promise<Plan> {
    return this.call(`scans/${encodeURIComponent(scan)}/plan`);
  }

  legends(scan: string, viewpoint: string): Promise<Legends> {
    return this.call(`${this.viewpoint(scan, viewpoint)}/legends`);
  }

  /** How far it is from a viewpoint, as Surround.parse() reads it. */
  async distances(scan: string, viewpoint: string): Promise<ArrayBuffer> {
    const response = await fetch(`${this.base}/api/v1/${this.viewpoint(scan, viewpoint)}/distances`);
    if (!response.ok) throw new Error(`no distances of viewpoint ${viewpoint}`);
    return response.arrayBuffer();
  }

  private viewpoint(scan: string, viewpoint: string): string {
    return `scans/${encodeURIComponent(scan)}/viewpoints/${encodeURIComponent(viewpoint)}`;
  }

  /** The address of a face's picture, 0 up, 1 back, 2 left, 3 front, 4 right, 5 down. */
  face(scan: string, viewpoint: string, layer: Layer, face: number): string {
    const [folder, suffix] = {
      colour: ['faces', 'jpg'],
      depth: ['depth', 'png'],
      class: ['classes', 'png'],
    }[layer] as [string, string];
    return `${this.base}/api/v1/${this.viewpoint(scan, viewpoint)}/${folder}/${face}.${suffix}`;
  }
}

/** The server that this page is from. */
export const api = new Api();

/** How to send a body. */
export const json = (body: unknown, method = 'POST') => ({
  method, body: JSON.stringify(body), headers: { 'Content-Type': 'application/json' },
});
