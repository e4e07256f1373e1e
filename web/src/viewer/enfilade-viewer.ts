/** The viewer as a library: `import { Viewer } from '/enfilade-viewer.js'`. See docs/web.md. */
import style from './viewer.css?inline';

// A page needs the script alone, whatever its content policy says of styles.
const sheet = new CSSStyleSheet();
sheet.replaceSync(style);
document.adoptedStyleSheets.push(sheet);

export { Flight, type Moment, type Timeline } from './flight.ts';
export { Legend } from './legend.ts';
export { MapPanel, storeyName } from './map_panel.ts';
export { MiniMap } from './mini_map.ts';
export { type Outline } from './outline_layer.ts';
export { Outlines } from './outlines.ts';
export { Player } from './player.ts';
export { agentRules, Viewer, type Pose, type Rules, type ViewerOptions } from './viewer.ts';
