/** Workers describe paths: `/collect?collection=NAME&key=K`, and what the platforms add. */
import { work } from '../work/flow.ts';
import { WriteTask } from '../work/write_task.ts';

work('write', (main, desk) => WriteTask.open(main, desk));
