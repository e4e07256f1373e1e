/** Files that people choose, plain or packed with gzip. */

/** What a file dialog offers where JSON is wanted. */
export const jsonFiles = '.json,.gz,application/json,application/gzip';

/** The text of a file; gzip is recognised by its first two bytes. Throws TypeError for damaged gzip. */
export async function textOf(file: Blob): Promise<string> {
  const [first, second] = new Uint8Array(await file.slice(0, 2).arrayBuffer());
  if (first !== 0x1f || second !== 0x8b) return file.text();
  return new Response(file.stream().pipeThrough(new DecompressionStream('gzip'))).text();
}
