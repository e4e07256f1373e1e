/** A task as its workers see it before they accept one, over the organiser's page. */
import type { Collection, Example, Kind } from '../collecting/collections.ts';
import { canShowBuildings, noGraphics } from '../elements/graphics.ts';
import { make } from '../elements/page.ts';
import { DialogueTask } from './dialogue_task.ts';
import { FindTask } from './find_task.ts';
import type { Desk, ShowTask } from './flow.ts';
import { GuideTask } from './guide_task.ts';
import { WalkTask } from './walk_task.ts';
import { WriteTask } from './write_task.ts';

const write = (main: HTMLElement, desk: Desk): Promise<WriteTask> => WriteTask.open(main, desk);
const shows: Readonly<Record<Kind, ShowTask>> = {
  write, describe: write, guide: (main, desk) => GuideTask.open(main, desk), walk: (main, desk) => WalkTask.open(main, desk),
  find: (main, desk) => FindTask.open(main, desk), dialogue: (main, desk) => DialogueTask.open(main, desk),
};

/** Resolves when the task is on the screen. Throws what keeps it from that. */
export async function showPreview(collection: Collection, example: Example): Promise<void> {
  const page = make('div', { class: 'task' });
  const close = make('button', { type: 'button' }, 'Close the preview');
  const dialog = make('dialog', { class: 'preview', 'aria-label': `As workers see it: ${collection.title}` },
    make('p', { class: 'buttons' }, make('strong', {}, 'As workers see it'), close), page);
  document.body.append(dialog);
  dialog.showModal();
  close.addEventListener('click', () => dialog.close());
  const closed = new Promise((resolve) => dialog.addEventListener('close', resolve, { once: true })).finally(() => dialog.remove());
  if (!canShowBuildings()) return page.replaceChildren(noGraphics('Use another browser to see it.'));
  try {
    const task = await shows[collection.kind](page, { collection, task: example, api: undefined, visit: undefined, proceed: () => {} });
    void closed.then(() => task.dispose());
  } catch (error) {
    dialog.close();
    throw error;
  }
}
