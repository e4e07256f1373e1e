/** Files that people choose, plain or packed with gzip. */

/** What a file dialog offers where JSON is wanted. */
export const jsonFiles = '.json,.gz,application/json,application/gzip';

/**
 * The text of a file; gzip is recognised by its first two bytes. It may have several members, with zeros behind them,
 * as on the server: DecompressionStream takes one member alone. Throws Error for damaged gzip.
 */
export async function textOf(file: Blob): Promise<string> {
  const [first, second] = new Uint8Array(await file.slice(0, 2).arrayBuffer());
  if (first !== 0x1f || second !== 0x8b) return file.text();
  const { Inflate, ZStream } = await import('pako'); // most files are plain
  const parts: BlobPart[] = [];
  let rest = new Uint8Array(await file.arrayBuffer());
  while (rest.length > 0) {
    const gunzip = new Inflate({ windowBits: 31 }); // gzip alone
    let stream = new ZStream();
    gunzip.onStart = (its) => void (stream = its);
    gunzip.push(rest, true);
    if (gunzip.err) throw new Error(`damaged gzip: ${gunzip.msg}`);
    parts.push(gunzip.result);
    rest = rest.subarray(rest.length - stream.avail_in);
    const next = rest.findIndex((byte) => byte !== 0);
    rest = rest.subarray(next < 0 ? rest.length : next);
  }
  return new Blob(parts).text();
}
