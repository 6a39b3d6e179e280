/PROG  KR_270_MI_F2O4SI
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "elastocal";
PROG_SIZE	= 0;
CREATE		= DATE 00-01-01  TIME 00:00:00;
MODIFIED	= DATE 00-01-01  TIME 00:00:00;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 112;
MEMORY_SIZE	= 0;
PROTECT		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50,
      TIME_SLICE	= 0,
      BUSY_LAMP_OFF	= 0,
      ABORT_REQUEST	= 0,
      PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
   1:  !Calibration campaign: 4 ;
   2:  !experiments in 3 configurations. ;
   3:  !Made by elastocal 0.1.0 from KR ;
   4:  !270 milling cell. ;
   5:  !plan sha256 0123456789abcdef ;
   6:  !Start: load all of ;
   7:  !KR_270_MI_F2O4SI, select ;
   8:  !KR_270_MI_F2O4SI, run it in T1 ;
   9:  !first. ;
  10:  !Robot: kuka-kr270. Joint values: ;
  11:  !deg, mm, as in the model. ;
  12:  !Forces act at the load point of ;
  13:  !the tool, in the axes of the ;
  14:  !robot base. ;
  15:  !No home position: the first ;
  16:  !motion starts where the robot ;
  17:  !stands. ;
  18:  !SAFETY: check this program at ;
  19:  !low speed in manual mode first. ;
  20:  !Motions between the points are ;
  21:  !not checked for collisions by ;
  22:  !this file. ;
  23:  !Set the payload of the empty ;
  24:  !calibration tool and leave it ;
  25:  !so, loaded and unloaded: the ;
  26:  !controller must not compensate ;
  27:  !what is to be measured. ;
  28:  !elastocal program 000000000000 ;
  29:  UFRAME_NUM=0 ;
  30:  UTOOL_NUM=1 ;
  31:  !to AP1 ;
  32:J P[1] 10% FINE    ;
  33:  !to P1 ;
  34:J P[2] 10% FINE    ;
  35:  WAIT   2.00(sec) ;
  36:  MESSAGE[Experiment 1/4: pose 1.] ;
  37:  MESSAGE[NO load. Measure M1.] ;
  38:  PAUSE ;
  39:  MESSAGE[Experiment 1/4: hang] ;
  40:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
  41:  MESSAGE[-2500 N.] ;
  42:  PAUSE ;
  43:  WAIT   2.00(sec) ;
  44:  MESSAGE[Experiment 1/4: pose 1.] ;
  45:  MESSAGE[LOADED. Measure M1.] ;
  46:  PAUSE ;
  47:  MESSAGE[Experiment 1/4: take the] ;
  48:  MESSAGE[load off. The robot] ;
  49:  MESSAGE[moves next.] ;
  50:  PAUSE ;
  51:  !to AP1 ;
  52:J P[1] 10% FINE    ;
  53:  !to P1 ;
  54:J P[2] 10% FINE    ;
  55:  WAIT   2.00(sec) ;
  56:  MESSAGE[Experiment 2/4: pose 1.] ;
  57:  MESSAGE[NO load. Measure M1.] ;
  58:  PAUSE ;
  59:  MESSAGE[Experiment 2/4: hang] ;
  60:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
  61:  MESSAGE[-2500 N.] ;
  62:  PAUSE ;
  63:  WAIT   2.00(sec) ;
  64:  MESSAGE[Experiment 2/4: pose 1.] ;
  65:  MESSAGE[LOADED. Measure M1.] ;
  66:  PAUSE ;
  67:  MESSAGE[Experiment 2/4: take the] ;
  68:  MESSAGE[load off. The robot] ;
  69:  MESSAGE[moves next.] ;
  70:  PAUSE ;
  71:  !to AP2 ;
  72:J P[3] 10% FINE    ;
  73:  !to P2 ;
  74:J P[4] 10% FINE    ;
  75:  WAIT   2.00(sec) ;
  76:  MESSAGE[Experiment 3/4: pose 2.] ;
  77:  MESSAGE[NO load. Measure M1.] ;
  78:  PAUSE ;
  79:  MESSAGE[Experiment 3/4: hang] ;
  80:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
  81:  MESSAGE[-2500 N.] ;
  82:  PAUSE ;
  83:  WAIT   2.00(sec) ;
  84:  MESSAGE[Experiment 3/4: pose 2.] ;
  85:  MESSAGE[LOADED. Measure M1.] ;
  86:  PAUSE ;
  87:  MESSAGE[Experiment 3/4: take the] ;
  88:  MESSAGE[load off. The robot] ;
  89:  MESSAGE[moves next.] ;
  90:  PAUSE ;
  91:  !to AP3 ;
  92:J P[5] 10% FINE    ;
  93:  !to P3 ;
  94:J P[6] 10% FINE    ;
  95:  WAIT   2.00(sec) ;
  96:  MESSAGE[Experiment 4/4: pose 3.] ;
  97:  MESSAGE[NO load. Measure M1.] ;
  98:  PAUSE ;
  99:  MESSAGE[Experiment 4/4: hang] ;
 100:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
 101:  MESSAGE[-2500 N.] ;
 102:  PAUSE ;
 103:  WAIT   2.00(sec) ;
 104:  MESSAGE[Experiment 4/4: pose 3.] ;
 105:  MESSAGE[LOADED. Measure M1.] ;
 106:  PAUSE ;
 107:  MESSAGE[Experiment 4/4: take the] ;
 108:  MESSAGE[load off. The robot] ;
 109:  MESSAGE[moves next.] ;
 110:  PAUSE ;
 111:  !to AP3 ;
 112:J P[5] 10% FINE    ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 1,	
	J1=   -0.5000 deg,	J2=  -51.2922 deg,	J3=   62.5588 deg,
	J4=  -32.0611 deg,	J5=  101.1598 deg,	J6=  -94.2903 deg
};
P[2]{
   GP1:
	UF : 0, UT : 1,	
	J1=    0.0000 deg,	J2=  -50.7922 deg,	J3=   63.0588 deg,
	J4=  -32.5611 deg,	J5=  101.6598 deg,	J6=  -93.7903 deg
};
P[3]{
   GP1:
	UF : 0, UT : 1,	
	J1=   -0.5000 deg,	J2=  -55.9571 deg,	J3=  -72.9034 deg,
	J4= -118.8938 deg,	J5=  -57.0916 deg,	J6= -179.7668 deg
};
P[4]{
   GP1:
	UF : 0, UT : 1,	
	J1=    0.0000 deg,	J2=  -55.4571 deg,	J3=  -72.4034 deg,
	J4= -119.3938 deg,	J5=  -56.5916 deg,	J6= -179.2668 deg
};
P[5]{
   GP1:
	UF : 0, UT : 1,	
	J1=   -0.5000 deg,	J2=   -2.1852 deg,	J3=   -4.2994 deg,
	J4=  -57.7496 deg,	J5=   39.0358 deg,	J6=  168.3163 deg
};
P[6]{
   GP1:
	UF : 0, UT : 1,	
	J1=    0.0000 deg,	J2=   -1.6852 deg,	J3=   -3.7994 deg,
	J4=  -58.2496 deg,	J5=   39.5358 deg,	J6=  168.8163 deg
};
/END
