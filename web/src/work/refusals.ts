/** What a server's refusal means for a worker, in words. */
import { make } from '../elements/page.ts';
import { ServerError } from '../server/api.ts';
import { BadLink } from './visit.ts';

/** No answer, or none that says anything of the work: it is worth asking again. */
export const isOutOfReach = (error: unknown): boolean =>
  error instanceof ServerError ? error.status >= 500 || error.status === 429 : error instanceof TypeError;

const lost = 'You were inactive for so long that this task was given to another worker.';
/** The lease is gone. */
export const lostText = `${lost} Load the page again for another one.`;
/** As lostText, where there is a text to be saved. */
export const lostDraftText = `${lost} Copy what you want to keep, and load the page again for another one.`;

/** What to say when the server takes no more of a task. */
export function explainLoss(error: unknown): Error {
  const { code, status } = error instanceof ServerError ? error : { code: '', status: 0 };
  if (code === 'lease-expired') return new Error(lostText);
  if (status === 401) return new Error('You were away for a day, and have to come in anew: load the page again. Nothing is lost.');
  return error instanceof Error ? error : new Error(String(error));
}

/** The heading of a page that could not begin. */
export function explained(error: unknown): string {
  if (isOutOfReach(error)) return 'The server cannot be reached';
  if (error instanceof ServerError && error.code === 'collection-closed') return 'This study is closed';
  if (error instanceof ServerError && error.code === 'conflict') return 'This assignment belongs to another worker';
  if (error instanceof ServerError || error instanceof BadLink) return 'This link does not work';
  return 'This page cannot be shown';
}

/** What went wrong, as sentences: no table of a file's faults. */
export function sentences(error: unknown): string[] {
  if (error instanceof TypeError) return ['There was no answer. Your connection may be interrupted.'];
  if (error instanceof ServerError && error.problems.length > 0) return error.problems.map(({ message }) => upper(message));
  return [upper(error instanceof Error ? error.message : String(error))];
}

const upper = (text: string): string => text.replace(/^[a-z](?=[a-z]* )/, (letter) => letter.toUpperCase());

export const troubles = (error: unknown): HTMLElement =>
  make('div', { role: 'alert' }, ...sentences(error).map((text) => make('p', { class: 'problem' }, text.endsWith('.') ? text : `${text}.`)));
