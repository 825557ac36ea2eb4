import { expect, test } from 'vitest';
import { scanFiles, withMaterials, withPictures } from './scanFiles';

test('names of photographs are replaced, options and colours stay', () => {
  const mtl = 'newmtl skin\nKd 1 1 1\nmap_Kd -s 1 1 1 C:\\scans of Jane\\Jane Doe.JPG\r\n map_Ka jane doe.jpg\n';
  expect(withPictures(mtl, new Map([['jane doe.jpg', 'picture-1.jpg']])))
    .toBe('newmtl skin\nKd 1 1 1\nmap_Kd -s 1 1 1 picture-1.jpg\r\n map_Ka picture-1.jpg\n');
  expect(() => withPictures('map_Kd other.png', new Map())).toThrow(/“other.png”/);
});

test('the scan asks for the material files that were given, once', () => {
  const obj = '# Jane\nmtllib jane.mtl\nv 0 0 0\nmtllib more.mtl\nusemtl skin\n';
  expect(withMaterials(obj, ['material-1.mtl'])).toBe('# Jane\nmtllib material-1.mtl\nv 0 0 0\n\nusemtl skin\n');
  expect(withMaterials(obj, [])).not.toMatch(/mtllib/);
});

test('one scan with its files; nothing else', async () => {
  const file = (name: string, text = 'x'): File => new File([text], name);
  const sent = await scanFiles([file('jane.png'), file('Jane.obj', 'mtllib Jane.mtl\nv 0 0 0'), file('Jane.mtl', 'map_Kd jane.png')]);
  expect(sent.map((s) => s.name)).toEqual(['picture-1.png', 'material-1.mtl', 'scan.obj']);
  expect(await sent[1].content.text()).toBe('map_Kd picture-1.png');
  expect(await sent[2].content.text()).toBe('mtllib material-1.mtl\nv 0 0 0');
  await expect(scanFiles([file('a.obj'), file('b.ply')])).rejects.toThrow(/one scan/);
  await expect(scanFiles([file('a.png')])).rejects.toThrow(/scan itself/);
});
