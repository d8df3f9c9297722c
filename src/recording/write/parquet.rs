//! A table as Parquet: a required column of doubles each, packed with zstd.

use std::sync::Arc;

use ::parquet::basic::{Compression, Encoding, Repetition, Type as Physical, ZstdLevel};
use ::parquet::data_type::DoubleType;
use ::parquet::errors::ParquetError;
use ::parquet::file::properties::WriterProperties;
use ::parquet::file::writer::SerializedFileWriter;
use ::parquet::schema::types::Type;

/// A table of these columns, which are equally long.
pub fn table(columns: &[(String, Vec<f64>)]) -> Result<Vec<u8>, ParquetError> {
    let field = |(name, _): &(String, Vec<f64>)| {
        let column = Type::primitive_type_builder(name, Physical::DOUBLE).with_repetition(Repetition::REQUIRED);
        Ok(Arc::new(column.build()?))
    };
    let fields = columns.iter().map(field).collect::<Result<Vec<_>, ParquetError>>()?;
    let schema = Arc::new(Type::group_type_builder("samples").with_fields(fields).build()?);
    // The bytes of numbers that differ in their last digits are packed best apart.
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_dictionary_enabled(false)
        .set_encoding(Encoding::BYTE_STREAM_SPLIT)
        .set_created_by("torquescope".to_owned());
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties.build()))?;
    let mut group = writer.next_row_group()?;
    for (_, values) in columns {
        let Some(mut column) = group.next_column()? else { break };
        column.typed::<DoubleType>().write_batch(values, None, None)?;
        column.close()?;
    }
    group.close()?;
    writer.into_inner()
}
