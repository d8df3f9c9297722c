//! Where each weight stands in the one flat vector of all parameters.

use super::kernel::{Element, PAD};

/// Index of a block in its [`Layout`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BlockId(pub(crate) usize);

/// One weight matrix, bias or vector of parameters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// Unique name, such as `mass_matrix/linear_0/w`.
    pub name: String,
    /// Rows as they are stored.
    pub rows: usize,
    /// Columns as they are stored.
    pub columns: usize,
    /// A matrix is stored inputs × outputs or, if this is set, outputs × inputs: always with its longer side along the rows, so
    /// that gradients are computed in full vectors.
    pub turned: bool,
    /// Index of its first element.
    pub offset: usize,
}

impl Block {
    /// Distance of two rows.
    pub fn stride(&self) -> usize {
        self.columns.next_multiple_of(PAD)
    }

    /// How many elements it takes, with its padding.
    pub fn size(&self) -> usize {
        self.rows * self.stride()
    }

    /// Its place in the flat vector.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.offset..self.offset + self.size()
    }

    /// (inputs, outputs) of a matrix, (1, length) of a vector.
    pub fn shape(&self) -> (usize, usize) {
        if self.turned { (self.columns, self.rows) } else { (self.rows, self.columns) }
    }

    /// Index into the flat vector of the weight from `input` to `output`.
    fn index(&self, input: usize, output: usize) -> usize {
        let (row, column) = if self.turned { (output, input) } else { (input, output) };
        self.offset + row * self.stride() + column
    }
}

/// The blocks of one network. Rows are padded to whole vectors; padding is always zero.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Layout {
    blocks: Vec<Block>,
}

impl Layout {
    /// Adds a matrix from `inputs` to `outputs`.
    pub fn matrix(&mut self, name: &str, inputs: usize, outputs: usize) -> BlockId {
        let turned = inputs > outputs;
        let (rows, columns) = if turned { (outputs, inputs) } else { (inputs, outputs) };
        self.push(Block { name: name.into(), rows, columns, turned, offset: self.size() })
    }

    /// Adds a vector.
    pub fn vector(&mut self, name: &str, length: usize) -> BlockId {
        self.push(Block { name: name.into(), rows: 1, columns: length, turned: false, offset: self.size() })
    }

    fn push(&mut self, block: Block) -> BlockId {
        self.blocks.push(block);
        BlockId(self.blocks.len() - 1)
    }

    /// Elements of the flat vector, with padding.
    pub fn size(&self) -> usize {
        self.blocks.last().map_or(0, |last| last.range().end)
    }

    /// How many parameters there are, without padding.
    pub fn parameter_count(&self) -> usize {
        self.blocks.iter().map(|block| block.rows * block.columns).sum()
    }

    /// All blocks, in order.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// The block with this id.
    pub fn block(&self, id: BlockId) -> &Block {
        &self.blocks[id.0]
    }

    /// The block with this name.
    pub fn find(&self, name: &str) -> Option<&Block> {
        self.blocks.iter().find(|block| block.name == name)
    }

    /// The values of a block, inputs × outputs, row after row, without padding.
    pub fn read<E: Element>(&self, block: &Block, flat: &[E]) -> Vec<f64> {
        let (inputs, outputs) = block.shape();
        let weight = |i| flat[block.index(i / outputs, i % outputs)].to_f64();
        (0..inputs * outputs).map(weight).collect()
    }

    /// Sets the values of a block from inputs × outputs, row after row; missing ones keep their values.
    pub fn write<E: Element>(&self, block: &Block, values: &[f64], flat: &mut [E]) {
        let (inputs, outputs) = block.shape();
        for (i, value) in values.iter().enumerate().take(inputs * outputs) {
            flat[block.index(i / outputs, i % outputs)] = E::from_f64(*value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_whichever_way_it_is_stored() {
        let mut layout = Layout::default();
        layout.matrix("in", 2, 5);
        layout.matrix("out", 5, 2);
        layout.vector("bias", 2);
        let mut flat = vec![0.0_f64; layout.size()];
        for block in layout.blocks() {
            let (inputs, outputs) = block.shape();
            let values: Vec<f64> = (0..inputs * outputs).map(|i| i as f64 + 1.0).collect();
            layout.write(block, &values, &mut flat);
            assert_eq!(layout.read(block, &flat), values);
        }
        assert_eq!(flat.iter().filter(|value| **value != 0.0).count(), layout.parameter_count());
    }
}
