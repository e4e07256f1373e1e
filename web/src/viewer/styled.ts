/** The viewer's styles. A page needs the script alone, whatever its content policy says of styles. */
import style from './viewer.css?inline';

const sheet = new CSSStyleSheet();
sheet.replaceSync(style);
document.adoptedStyleSheets.push(sheet);
