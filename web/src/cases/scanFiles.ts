// A photographed scan as several files, which name each other. Their own names may name a person and
// stay in the browser: the server gets the same files under names that say nothing.
export interface Sent { name: string; content: Blob }

const ending = (name: string): string => /\.[^.]+$/.exec(name.toLowerCase())?.[0] ?? '';
const surfaces = ['.obj', '.ply', '.stl', '.zip'], pictures = ['.jpg', '.jpeg', '.png'];

/** Throws a sentence when the files are not one scan. */
export async function scanFiles(files: File[]): Promise<Sent[]> {
  const surface = files.filter((f) => surfaces.includes(ending(f.name)));
  if (surface.length !== 1) throw new Error(surface.length ? 'Choose one scan only, with its material file and photographs' : 'Choose the scan itself, too (.obj, .ply, .stl or .zip)');
  if (ending(surface[0].name) !== '.obj') return [{ name: surface[0].name, content: surface[0] }];
  const materials = files.filter((f) => ending(f.name) === '.mtl'), photographs = files.filter((f) => pictures.includes(ending(f.name)));
  const sent: Sent[] = photographs.map((f, i) => ({ name: `picture-${i + 1}${ending(f.name)}`, content: f }));
  const renamed = new Map(photographs.map((f, i) => [f.name.toLowerCase(), sent[i].name]));
  for (const [i, m] of materials.entries()) sent.push({ name: `material-${i + 1}.mtl`, content: new Blob([withPictures(await m.text(), renamed)]) });
  sent.push({ name: 'scan.obj', content: new Blob([withMaterials(await surface[0].text(), materials.map((_, i) => `material-${i + 1}.mtl`))]) });
  return sent;
}

/** The first mtllib line names the given files; what was not given is not asked for. */
export function withMaterials(obj: string, materials: string[]): string {
  let first = true;
  return obj.replace(/^[ \t]*mtllib[ \t].*$/gm, () => {
    const line = first && materials.length ? `mtllib ${materials.join(' ')}` : '';
    first = false;
    return line;
  });
}

/** `map_Kd -s 1 1 1 C:\scans\her name.jpg`: options stay, folders go, the file's new name comes in. */
export function withPictures(mtl: string, renamed: Map<string, string>): string {
  return mtl.replace(/^([ \t]*map_\w+[ \t]+(?:-\w+[ \t]+(?:[-\d.]+[ \t]+|on[ \t]+|off[ \t]+)*)*)(.*)$/gm, (_, head: string, path: string) => {
    const name = path.trim().split(/[\\/]/).pop() ?? '', now = renamed.get(name.toLowerCase());
    if (!now) throw new Error(`The material file names the photograph “${name}”: choose it, too`);
    return head + now;
  });
}
