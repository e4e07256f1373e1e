/** Workers describe paths and objects: `/collect?collection=NAME&key=K`, and what the platforms add. */
import { work } from '../work/flow.ts';
import { GuideTask } from '../work/guide_task.ts';
import { WriteTask } from '../work/write_task.ts';

declare global {
  interface Window {
    /** For tests. */
    writeTask?: WriteTask | GuideTask;
  }
}

const write = async (...args: Parameters<typeof WriteTask.open>): Promise<WriteTask> => (window.writeTask = await WriteTask.open(...args));
work({ write, describe: write, guide: async (main, desk) => (window.writeTask = await GuideTask.open(main, desk)) });
