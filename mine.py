import workbench as wb

study = wb.Study("mine", "T", "Q?", "M.", sections=lambda results: [])
