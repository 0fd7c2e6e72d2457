#!/usr/bin/env python3
"""Whether the pictures of runs show bodies in the fluid that carries them.

    python3 pictures.py PROGRAM WORK             reads run.xdmf and what it names by an XML parser and h5py
    pvpython pictures.py PROGRAM WORK --readers  opens run.xdmf with ParaView: XDMF Reader, Xdmf3 Reader T
                                                 (Xdmf3 Reader S takes files for pieces of one block)

Runs a few short scenarios into WORK, then demands of every frame: the channel's outline is there;
each body's centre lies within the fluid's bounds, and those within the channel's; the mean velocity
over each body's surface, and that of trajectory.csv, are within 5% of the fluid's there, frame 0
included; and wall nodes move as the walls do.
"""
import csv
import os
import subprocess
import sys
import xml.etree.ElementTree as xml

import numpy as np

BODIES = """
[run]
time_limit = 1.5
[output]
every = 0.25
surfaces_every = 0.25
field_every = 0.5
[[body]]
name = "lead"
kind = "rigid"
radius = 0.35
x = 0.3
z = 0.6
[[body]]
name = "lag"
laplace = 50
radius = 0.35
x = -0.25
z = -0.6
"""
# The fluid on a body's surface is that of its markers only where the two are one, and its nodes stay
# in the channel's box only where the lattice rests.
SURFACES = ('[membrane]\nretraction = 0.0\n[rigid]\nretraction = 0.0\n'
            '[fluid]\nframe = "walls"\n')
CHANNEL = SURFACES + '[channel]\nnodes = 16\nlength = 5\n'
CASES = {
    'whole': CHANNEL,
    'half': CHANNEL + 'symmetry = "y"\n',
    'nodes': CHANNEL.replace('16', '17') + 'walls = "regularized"\nsymmetry = "y"\n',
    'wide': CHANNEL + 'half_width_y = 1.5\n',
    'plates': CHANNEL + 'side_walls = false\nreynolds = 4\nwall_velocity = [1, 3]\n',
}


class Fluid:
    """A field on a regular grid: values[k, j, i]."""

    def __init__(self, origin, spacing, values):
        self.origin, self.spacing, self.values = map(np.asarray, (origin, spacing, values))

    def bounds(self):
        counts = np.array(self.values.shape[2::-1])
        return self.origin, self.origin + self.spacing * (counts - 1)

    def at(self, points):
        """Trilinear; beyond the ends along z, which are one plane, from the other side."""
        s = (points - self.origin) / self.spacing
        s[:, 2] %= self.values.shape[0] - 1
        low = np.minimum(s.astype(int), np.array(self.values.shape[2::-1]) - 2)
        f = s - low
        total = 0
        for corner in np.ndindex(2, 2, 2):
            weight = np.prod(np.where(corner, f, 1 - f), axis=1)
            i, j, k = (low + corner).T
            total = total + weight[:, None] * self.values[k, j, i]
        return total


def frames_of_files(directory):
    """Time -> block name -> points and velocity, or Fluid; as the files say."""
    import h5py

    def values(item):
        if item.get('Format') == 'XML':
            return np.array(item.text.split(), float)
        name, _, dataset = item.text.partition(':')
        with h5py.File(os.path.join(directory, name), 'r') as file:
            found = file[dataset][()]
        assert list(found.shape) == [int(n) for n in item.get('Dimensions').split()]
        return found

    frames = {}
    for grid in xml.parse(os.path.join(directory, 'run.xdmf')).iter('Grid'):
        if grid.get('GridType') != 'Uniform':
            continue
        arrays = {a.get('Name'): values(a.find('DataItem')) for a in grid.findall('Attribute')}
        geometry = [values(item) for item in grid.findall('Geometry/DataItem')]
        blocks = frames.setdefault(float(grid.find('Time').get('Value')), {})
        if grid.find('Geometry').get('GeometryType') == 'ORIGIN_DXDYDZ':
            block = Fluid(geometry[0][::-1], geometry[1][::-1], arrays['velocity [nu/W]'])
        else:
            block = (geometry[0], arrays)
        assert grid.get('Name') not in blocks
        blocks[grid.get('Name')] = block
    return frames


def frames_of_reader(make_reader):
    """The same, as one of ParaView's readers shows it."""
    from paraview import servermanager
    from vtkmodules.util import numpy_support
    from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet

    def vtk_to_numpy(array):
        return numpy_support.vtk_to_numpy(array).copy()  # the reader takes its memory back

    def leaves(block, names):
        if block is None:
            return
        if not block.IsA('vtkMultiBlockDataSet'):
            yield names, block
            return
        for n in range(block.GetNumberOfBlocks()):
            own = block.GetMetaData(n) if block.HasMetaData(n) else None
            named = own is not None and own.Has(vtkCompositeDataSet.NAME())
            yield from leaves(block.GetBlock(n),
                              names + ([own.Get(vtkCompositeDataSet.NAME())] if named else []))

    reader = make_reader()
    reader.UpdatePipelineInformation()
    frames = {}
    for time in reader.TimestepValues:
        reader.UpdatePipeline(time)
        blocks = frames[time] = {}
        for names, block in leaves(servermanager.Fetch(reader), []):
            data, of_grid = block.GetPointData(), block.GetFieldData()
            arrays = {data.GetArrayName(n): vtk_to_numpy(data.GetArray(n))
                      for n in range(data.GetNumberOfArrays())}
            arrays.update((of_grid.GetArrayName(n), vtk_to_numpy(of_grid.GetArray(n)).ravel())
                          for n in range(of_grid.GetNumberOfArrays()))
            if block.IsA('vtkImageData'):
                shape = block.GetDimensions()[::-1] + (3,)
                shown = Fluid(block.GetOrigin(), block.GetSpacing(),
                              arrays['velocity [nu/W]'].reshape(shape))
            else:
                shown = (vtk_to_numpy(block.GetPoints().GetData()), arrays)
            # The outer name is the same in every frame with one reader, the inner with the other.
            name, = {n for n in names if '[' not in n}
            assert name not in blocks
            blocks[name] = shown
    return frames


def check(frames, rows, case):
    lengths = (2, 3 if case == 'wide' else 2, 5)
    assert len(frames) == len(rows) == 7, (len(frames), len(rows))
    with_fluid = 0
    for (time, blocks), row in zip(sorted(frames.items()), rows):
        assert abs(time - float(row['t[W^2/nu]'])) < 1e-12
        outline, about = blocks['channel']
        assert np.allclose(about['t [W^2/nu]'], time) and np.allclose(about['size [W]'], lengths)
        assert np.allclose(np.ptp(outline, axis=0), lengths) and np.allclose(outline.mean(0), 0)
        if 'fluid' not in blocks:
            assert set(blocks) == {'channel', 'lead', 'lag'}, set(blocks)
            continue
        with_fluid += 1
        fluid = blocks['fluid']
        low, high = fluid.bounds()
        spacing = fluid.spacing[0]
        assert np.all(low >= outline.min(0) - 1e-9) and np.all(high <= outline.max(0) + 1e-9)
        gap = 0 if case == 'nodes' else np.array([.5, .5, 0]) * spacing
        assert np.allclose(outline.max(0) - high, gap) and np.allclose(low - outline.min(0), gap)
        if case == 'nodes':
            assert np.allclose(fluid.values[:, [0, -1]], 0) and np.allclose(
                fluid.values[:, :, [0, -1]], 0)
        for body in 'lead', 'lag':
            points, arrays = blocks[body]
            centre = points.mean(0)
            assert np.all(centre >= low) and np.all(centre <= high), (case, time, body, centre)
            z = float(row[body + '_z[W]'])
            turns = (z - centre[2]) / 5
            assert abs(turns - round(turns)) < 1e-3, (case, time, body, z, centre)
            there = fluid.at(points).mean(0)
            shown = arrays['velocity [nu/W]'].mean(0)
            told = np.array([float(row[f'{body}_v{axis}[nu/W]']) for axis in 'xyz'])
            for velocity in shown, told:
                error = np.linalg.norm(velocity - there) / np.linalg.norm(there)
                assert error < .05, (case, time, body, velocity, there)
    assert with_fluid == 4, with_fluid


def main():
    program, work = sys.argv[1:3]
    os.makedirs(work, exist_ok=True)
    readers = {}
    if sys.argv[3:] == ['--readers']:
        from paraview import simple
        readers = {
            'XDMFReader': lambda file: simple.XDMFReader(FileNames=[file]),
            'Xdmf3ReaderT': lambda file: simple.Xdmf3ReaderT(FileName=[file]),
        }
    for case, channel in CASES.items():
        file, out = os.path.join(work, case + '.toml'), os.path.join(work, case)
        with open(file, 'w', encoding='utf-8') as text:
            text.write(channel + BODIES)
        subprocess.run([program, 'run', file, '-o', out, '--force'], check=True)
        with open(os.path.join(out, 'trajectory.csv'), encoding='utf-8') as text:
            rows = list(csv.DictReader(text))
        if not readers:
            check(frames_of_files(out), rows, case)
            continue
        for name, make in readers.items():
            check(frames_of_reader(lambda: make(os.path.join(out, 'run.xdmf'))), rows, case)
            print(case, name, 'all frames as they should be')


if __name__ == '__main__':
    main()
