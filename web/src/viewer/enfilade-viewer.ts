/** The viewer as a library: `import { Viewer } from '/enfilade-viewer.js'`. See docs/web.md. */
import './styled.ts';

export { NotInScan } from './arrival.ts';
export { Flight, type Moment, type Timeline } from './flight.ts';
export { Legend } from './legend.ts';
export { MapPanel } from './map_panel.ts';
export { MiniMap } from './mini_map.ts';
export { agentRules, type Rules, type ViewerOptions } from './options.ts';
export { type Outline } from './outline_layer.ts';
export { Outlines } from './outlines.ts';
export { Player } from './player.ts';
export { storeyName } from './storey_name.ts';
export { Viewer, type Pose } from './viewer.ts';
